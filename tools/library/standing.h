// How a sidecar on the disk stands to what a bake would write: decided by content, never by time.
#pragma once

#include <string>
#include <vector>

#include "making.h"

namespace vcd {

// Of the sidecar at asset.output.
struct Standing {
  // Empty: the sidecar is sound, was made by this baker with these settings, and the files that it was made of have
  // the same content now. Else a clause that says why not.
  std::string reason;
  // If up to date: files that the mesh file names, relative to its folder.
  std::vector<std::filesystem::path> dependencies;
  Json objects;  // likewise: their description, for reports
  uint64_t bytes = 0;
  bool exists = false;

  bool up_to_date() const { return reason.empty(); }
};

// Reads the whole sidecar and the mesh's files. Safe on any bytes, from any thread.
Standing standing_of(const Asset& asset);

}  // namespace vcd
