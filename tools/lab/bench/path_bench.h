// Single calls and wavefronts of a path tracer's shadow rays: Embree's ways and sidecars, timed side by side and
// judged.
#pragma once

#include <string>
#include <vector>

#include "high_quality.h"
#include "render/judge.h"
#include "render/path_casters.h"
#include "timing.h"

namespace vcd::bench {

// One way to answer by sidecars.
struct PathWay {
  std::string name;
  render::SidecarPaths paths;
};

// Ways of one use.
struct PathTimes {
  std::vector<Timing> embree, vcd;  // vcd: the first is look-ups with rtcOccluded1 behind them, where that was timed
};

struct PathComparison {
  std::string name;
  // differ: answers of the first way that are not Embree's. wrong: in exact arithmetic, of the first `judged`.
  uint64_t segments = 0, blocked = 0, differ = 0, judged = 0, wrong_embree = 0;
  std::vector<uint64_t> wrong;  // of each way
  PathTimes single, wavefronts;
};

class PathBench {
 public:
  // All outlive this. ways: at least one. objects[i] stands for world.objects[i].
  PathBench(const render::World& world, const HighQualityCasters& high, const std::vector<PathWay>& ways,
            std::span<const Object> objects, int repetitions)
      : world_(world), high_(high), ways_(ways), judge_(world, objects), repetitions_(repetitions) {}

  // rays: path by path, as trace_paths() gives them; not none.
  PathComparison compare(const std::string& name, std::vector<render::PathRay> rays) const;

 private:
  using Variants = std::vector<Variant>;

  void judge(const render::AskedRays& rays, PathComparison& result) const;
  PathTimes time(const Variants& embree, const Variants& vcd) const;
  RTCScene casters(bool high) const { return high ? high_.scene() : world_.shadow_casters(); }
  template <class Ask>
  Variant one_by_one(std::string name, const render::AskedRays& rays, Ask ask) const;
  Variants single_embree(const render::AskedRays& rays) const;
  Variants single_vcd(const render::AskedRays& rays) const;
  Variants wavefront_embree(const render::AskedRays& rays) const;
  Variants wavefront_vcd(const render::AskedRays& rays) const;

  const render::World& world_;
  const HighQualityCasters& high_;
  const std::vector<PathWay>& ways_;
  render::Judge judge_;
  int repetitions_;
  mutable volatile uint64_t sink_ = 0;  // keeps the answers from being optimised away
};

// "wrong" has an entry for each of `ways`.
tools::Json describe(const PathComparison& compared, const std::vector<PathWay>& ways);

}  // namespace vcd::bench
