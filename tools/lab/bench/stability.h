// Where methods fail: wrong and resolved answers of sidecars and of Embree while one parameter is driven to its
// extremes.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/program.h"
#include "stability_meshes.h"

namespace vcd::bench {

// Look-ups of three sidecars; a sidecar's hierarchy without look-ups; Embree.
inline constexpr const char* kStabilityMethods[] = {"proven",    "hybrid", "sampled",
                                                    "hierarchy", "embree", "embree_robust"};
inline constexpr size_t kStabilityMethodCount = std::size(kStabilityMethods);
inline constexpr size_t kLookUpMethods = 3, kHierarchyMethod = 3, kSidecarMethods = 4, kEmbreeMethod = 4,
                        kRobustMethod = 5;

// One mesh and one set of segments, each method judged by the referee.
struct StabilityCounts {
  uint64_t wrong = 0, resolved = 0;
};
struct StabilityPoint {
  uint64_t rays = 0, blocked = 0;  // the latter by the referee
  std::string refused;             // why no sidecar could be baked; then nothing was asked
  std::string no_hierarchy;        // why a sidecar that could be baked has none; then it was not asked
  StabilityCounts counts[kStabilityMethodCount];
  uint64_t wrong_proven = 0;  // of hybrid's answers, with proofs alone
  // Of horizons, asked with the triangle that the segment was made for, else with any; resolved: clear. Of meshes for
  // which horizons are not worth it: none.
  StabilityCounts horizons;
};

struct StabilityMesh;  // a mesh with its sidecars, tracers and referee

struct StabilitySweep {
  std::string id, title, parameter, scale;  // scale: log, linear, category
  struct Point {
    nlohmann::ordered_json x;
    std::function<baker::SourceMesh()> mesh;  // null: that of the point before
    SegmentMaker segment;
    uint64_t rays;
    SelfSegmentMaker from_self = nullptr;  // in its place: segments that begin on a triangle
  };
  std::vector<Point> points;
};

// quick: fewer points and rays.
std::vector<StabilitySweep> stability_sweeps(bool quick);

// How sidecars are baked.
struct StabilityBakes {
  uint32_t depth = 4;
  // Deep only where a sample of each point's segments goes, drawn with another seed, and of lines through the box.
  bool for_segments = false;
  uint64_t budget_bytes = uint64_t{1} << 20;  // then, of each sidecar
};

// Runs one sweep; visit(point index, what came of it).
void run_sweep(const StabilitySweep& sweep, const StabilityBakes& bakes,
               const std::function<void(size_t, const StabilityPoint&)>& visit);

struct StabilityOptions {
  std::string folder;
  bool quick = false;
  StabilityBakes bakes;
};

// All sweeps: a table on standard output and stability.json in the folder. Returns the exit code: difference if a proof
// or a hierarchy was wrong.
int run_stability(const StabilityOptions& options, const std::string& command, tools::OutputFormat format);

}  // namespace vcd::bench
