// Where a scene's results and sidecars are kept, and the bakes of all trees that it is measured with.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "configuration.h"
#include "render/renderer.h"
#include "render/world.h"
#include "results.h"

namespace vcd::bench {

constexpr const char* kUnclassified = "unclassified";  // a sidecar that answers nothing: what look-ups cost

// One scene's part of the results and of their folder.
class SceneEntry {
 public:
  SceneEntry(const std::string& name, Results& results) : name_(name), results_(results) {}

  tools::Json& scene() { return results_.scene(name_); }
  tools::Json& variant(const std::string& id) { return Results::variant(scene(), id); }
  std::filesystem::path sidecar_path(const std::string& id) const {
    return results_.folder() / "sidecars" / (name_ + "-" + id + ".vcd");
  }
  std::string label(const std::string& what) const { return name_ + ": " + what; }
  Error stopped() const { return {ErrorCode::runtime, name_ + ": interrupted; the same command goes on from here"}; }

 protected:
  const std::string& name_;
  Results& results_;
};

// The trees that are wanted and those of earlier runs: all are timed together.
std::vector<Configuration> with_measured(std::vector<Configuration> wanted, const tools::Json& scene);

struct BakesOfScene {
  double budget_mb = 0;                    // of an object that is baked for a demand; 0: the default of bakes
  size_t most_recorded = size_t{1} << 21;  // of the picture's rays, for that demand
  bool horizons = false;                   // of trees that are baked by proof
};

// Bakes each tree that is missing, and the sidecar that answers nothing; describes and saves each. Demands are recorded
// from the picture with another seed. The first error ends it.
std::optional<Error> bake_missing(const SceneEntry& entry, const render::World& world,
                                  const std::vector<Configuration>& configurations,
                                  const render::RenderSettings& picture, const BakesOfScene& bakes, bool quiet);

}  // namespace vcd::bench
