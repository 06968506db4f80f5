// Mesh files, as every program takes them.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <vcd/baker/ingest.h>
#include <vcd/baker/prepare.h>
#include <vcd/format/contents.h>

namespace vcd::tools {

// "x,y,z" of a shift, shortest that reads back as the same doubles; and back. Nothing for what are not three numbers.
std::string shift_text(const std::array<double, 3>& shift);
std::optional<std::array<double, 3>> parse_shift(std::string_view text);

// How the mesh file of a sidecar was read: so it has to be read to be held against the sidecar, or drawn with it. What
// no sidecar may decide, whether files outside the folder are read, comes from `base`.
baker::IngestOptions ingest_options_of(const SidecarContents& sidecar, baker::IngestOptions base = {});

// A mesh file, read in a child process, whose meshes are prepared one after another. A mesh that cannot be prepared,
// since it has no area or no box in 32-bit floats, is left out with a note as long as another one can.
class MeshFile {
 public:
  // Errors: those of ingest_isolated().
  static Result<MeshFile> read(const std::filesystem::path& path, const baker::IngestOptions& options,
                               const baker::IngestLimits& limits = {});

  // The next mesh that can be prepared. Nothing when there are no more.
  std::optional<baker::PreparedMesh> next();

  // Of the meshes that next() has passed so far:
  std::optional<Error> fault() const;                // if there was none that can be prepared: why the last one cannot
  std::vector<baker::Placement> placements() const;  // of those that it gave, which are numbered in that order

  struct Unusable {
    std::string place;  // "mesh 0 NAME"
    Error error;
  };
  const std::vector<Unusable>& unusable() const { return unusable_; }
  const std::vector<std::string>& notes() const { return ingested_.notes; }  // what the file lacks now, a sentence each
  const std::vector<baker::SceneLight>& lights() const { return ingested_.lights; }
  const std::vector<baker::SourceFile>& sources() const { return ingested_.sources; }

 private:
  MeshFile(const std::filesystem::path& path, baker::Ingested&& ingested)
      : path_(path), ingested_(std::move(ingested)) {}

  std::filesystem::path path_;
  baker::Ingested ingested_;
  size_t next_ = 0;
  std::vector<uint32_t> given_;  // indices into ingested_.meshes
  std::vector<Unusable> unusable_;
};

struct LoadedMeshes {
  std::vector<baker::PreparedMesh> meshes;  // at least one
  std::vector<baker::Placement> placements;
  std::vector<std::string> notes;
};

// All meshes of a file at once. Errors: those of MeshFile::read() and MeshFile::fault().
Result<LoadedMeshes> load_meshes(const std::filesystem::path& path, const baker::IngestOptions& options);

// The mesh that is embedded for an object, decoded in a child process. `path` names the sidecar in messages.
Result<baker::PreparedMesh> embedded_mesh(const std::string& path, const ObjectContents& object);

}  // namespace vcd::tools
