// What a bake will cost and be worth, before it is done.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <vcd/baker/horizon.h>
#include <vcd/baker/mesh_health.h>

namespace vcd::baker {

struct DepthForecast {
  uint32_t depth;
  uint64_t bytes;          // of the tree, before demote-merge
  double seconds;          // of the bake on the threads at hand; the probe and the audit are not in it
  double resolved;         // share of all cells that are clear or blocked
  double resolved_shadow;  // share of segments that look like shadow rays and pierce the box: isotropic ones, as light
                           // from all around sends them to points all around
  double gain;  // time of tracing these segments one by one, divided by that of looking up and tracing the rest
};

// What proofs of blocked came to, in a sample of all cells of a level.
struct BlockedProofs {
  uint32_t level = 0;
  uint32_t cells = 0;           // of the sample
  uint32_t look_blocked = 0;    // to 16 rays: in these a proof was tried
  uint32_t proven = 0;          // of these
  uint32_t at_boundary = 0;     // not proven, and a sheet ends at a boundary edge in the cell
  uint32_t at_nonmanifold = 0;  // likewise at an edge of three triangles or more
};

struct Plan {
  std::vector<DepthForecast> forecasts;     // of depths 1, 2, …
  uint32_t depth = 0;                       // the one that was picked; 0: a sidecar would not pay
  std::string reason;                       // for that, a clause
  double seconds = 0;                       // that the probe took
  std::optional<HorizonForecast> horizons;  // if they were asked for, of an object that can have them
  // Of plan() alone, not of a bake that picks its depth:
  MeshHealth health;
  std::optional<BlockedProofs> proofs;  // if the method proves; at the depth that was picked, or at 5
};

}  // namespace vcd::baker
