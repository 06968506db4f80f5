// Folders of sidecars, found by the geometry that they are of.
//
//   auto store = vcd::SidecarStore::open({{"sidecars"}});
//   auto hash = vcd::geometry_hash(positions, faces);     // of the renderer's own buffers
//   auto tree = store->find(*hash);                       // Result<std::optional<Object>>
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <vcd/format/error.h>
#include <vcd/format/geometry_hash.h>
#include <vcd/runtime/sidecar.h>

namespace vcd {

class SidecarStore {
 public:
  // Looks for *.vcd in the folders and all below, and reads the table of objects of each. A file whose table cannot be
  // read is passed over: see passed_over(). Errors: io (a folder cannot be read); runtime (out of memory).
  // options  of every file, when it is opened
  static Result<SidecarStore> open(std::span<const std::filesystem::path> folders, const OpenOptions& options = {});

  SidecarStore(SidecarStore&&) noexcept;
  SidecarStore& operator=(SidecarStore&&) noexcept;
  ~SidecarStore();

  // The object of that geometry; none if no file had it. Its file is opened when the first of its objects is asked for,
  // once, and stays open as long as the store lives, and so do its objects. Of two files with it, the one that comes
  // first counts: by folders as they were given, then by path.
  // Errors: those of Sidecar::open(); io too where the file was replaced since, and holds the geometry no longer.
  // Threads: any number at once. Those that ask for one file wait while it is opened; no other one waits.
  Result<std::optional<Object>> find(const GeometryHash& geometry) const;

  size_t size() const noexcept;  // different geometries
  // Why files were passed over, one error each.
  const std::vector<Error>& passed_over() const noexcept;

 private:
  struct State;
  explicit SidecarStore(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace vcd
