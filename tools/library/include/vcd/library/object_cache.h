// Baked objects that need not be baked again: from a cache folder, or from the sidecar that is about to be replaced.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <vcd/baker/prepare.h>
#include <vcd/format/contents.h>
#include <vcd/format/file_bytes.h>
#include <vcd/writer/writer.h>

#include <vcd/library/settings.h>

namespace vcd::library {

// One object of a sidecar file that is kept open, for a mesh of the same geometry.
class CachedObject {
 public:
  CachedObject(std::shared_ptr<const FileBytes> file, std::shared_ptr<const SidecarContents> contents, size_t index,
               const baker::PreparedMesh& mesh);
  ObjectToWrite to_write() const;  // with what its record says of the mesh's source. Points into this
  TreeView tree() const { return contents().tree; }

 private:
  const ObjectContents& contents() const { return contents_->objects[index_]; }

  std::shared_ptr<const FileBytes> file_;
  std::shared_ptr<const SidecarContents> contents_;
  size_t index_;
  std::string name_;
  ObjectRecord record_;
};

// Content-addressed: an object is found by the hash of its geometry, of the settings that decide about its bytes, and
// of the baker's revision, whatever the file it came from. An entry is a sidecar of one object, FOLDER/xx/HASH.vcd,
// that says what it holds; it is read as a stranger's file is, and what is damaged or says something else is not there.
// Any number of machines and users may share a folder (who may write to it must be trusted: an entry's cells are not
// traced again); entries may be deleted at any time.
class ObjectCache {
 public:
  explicit ObjectCache(std::filesystem::path folder) : folder_(std::move(folder)) {}  // empty: no cache

  std::optional<CachedObject> find(const baker::PreparedMesh& mesh, const BakeSettings& settings) const;
  // Errors: io. Not being kept is no reason to fail a bake.
  std::optional<Error> keep(const baker::PreparedMesh& mesh, const BakeSettings& settings,
                            const ObjectToWrite& object) const;

 private:
  std::filesystem::path folder_;
};

// The object of that geometry in a sidecar that this baker made with the same settings; nothing otherwise.
std::optional<CachedObject> find_in_sidecar(const std::filesystem::path& sidecar, const baker::PreparedMesh& mesh,
                                            const BakeSettings& settings);

// The same, whatever the settings.
std::optional<CachedObject> find_older_in_sidecar(const std::filesystem::path& sidecar,
                                                  const baker::PreparedMesh& mesh);

}  // namespace vcd::library
