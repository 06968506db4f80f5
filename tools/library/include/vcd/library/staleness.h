// Whether a sidecar on the disk is what a bake would write now. Content decides, never the time of a file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <vcd/library/assets.h>

namespace vcd::library {

// Of the sidecar at asset.output.
struct Staleness {
  // Why the sidecar is stale, a clause. Empty if it is up to date: it is sound, this baker made it with these settings,
  // and the files that it was made of have the same content now.
  std::string reason;
  // Only if it is up to date:
  std::vector<std::filesystem::path> dependencies;  // files that the mesh file names, relative to its folder
  uint64_t bytes = 0;                               // of the sidecar
  std::string report;                               // JSON: {"bytes", "objects"}

  bool up_to_date() const { return reason.empty(); }
};

// Reads the whole sidecar and the mesh's files. Safe on any bytes, from any thread.
Staleness staleness_of(const Asset& asset);

}  // namespace vcd::library
