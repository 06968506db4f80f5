#include "path_bench.h"

#include <algorithm>

#include "render/packets.h"

namespace vcd::bench {

using namespace render;
namespace {

constexpr size_t kJudged = 100'000;  // segments of each kind that the referee judges, at most
constexpr std::pair<const char*, bool> kBuilds[] = {{"", false}, {", build of high quality", true}};

}  // namespace

PathComparison PathBench::compare(const std::string& name, std::vector<PathRay> rays) const {
  PathComparison result;
  result.name = name;
  const AskedRays paths(rays);
  sort_as_wavefronts(rays);
  const AskedRays wavefronts(rays);
  judge(paths, result);
  result.single = time(single_embree(paths), single_vcd(paths));
  result.wavefronts = time(wavefront_embree(wavefronts), wavefront_vcd(wavefronts));
  return result;
}

void PathBench::judge(const AskedRays& rays, PathComparison& result) const {
  result.segments = rays.segments.size();
  result.judged = std::min(kJudged, rays.segments.size());
  result.wrong.assign(ways_.size(), 0);
  for (size_t i = 0; i < rays.segments.size(); ++i) {
    const bool embree = occluded_by_bvh(casters(false), rays.segments[i]), first = ways_[0].paths.occluded(rays, i);
    result.blocked += embree, result.differ += embree != first;
    if (i >= result.judged) continue;
    const bool truth = judge_.blocked(rays.segments[i]);
    result.wrong_embree += embree != truth;
    for (size_t w = 0; w < ways_.size(); ++w) result.wrong[w] += ways_[w].paths.occluded(rays, i) != truth;
  }
}

PathTimes PathBench::time(const Variants& embree, const Variants& vcd) const {
  Variants all = embree;
  all.insert(all.end(), vcd.begin(), vcd.end());
  const std::vector<Timing> timings = time_interleaved(all, repetitions_);
  const auto middle = timings.begin() + static_cast<std::ptrdiff_t>(embree.size());
  return {{timings.begin(), middle}, {middle, timings.end()}};
}

// ask(i) -> bool, of each ray.
template <class Ask>
Variant PathBench::one_by_one(std::string name, const AskedRays& rays, Ask ask) const {
  return {std::move(name), [this, &rays, ask] {
            uint64_t blocked = 0;
            for (size_t i = 0; i < rays.segments.size(); ++i) blocked += ask(i);
            sink_ = blocked;
          }};
}

PathBench::Variants PathBench::single_embree(const AskedRays& rays) const {
  Variants variants;
  for (const auto& [build, high] : kBuilds)
    variants.push_back(one_by_one(std::string("rtcOccluded1") + build, rays, [&rays, scene = casters(high)](size_t i) {
      return occluded_by_bvh(scene, rays.segments[i]);
    }));
  return variants;
}

PathBench::Variants PathBench::single_vcd(const AskedRays& rays) const {
  Variants variants = {one_by_one("look-ups, then rtcOccluded1", rays, [this, &rays, scene = casters(false)](size_t i) {
    return ways_[0].paths.occluded_by(scene, rays, i);
  })};
  for (const PathWay& way : ways_)
    variants.push_back(one_by_one(way.name, rays, [&way, &rays](size_t i) { return way.paths.occluded(rays, i); }));
  return variants;
}

PathBench::Variants PathBench::wavefront_embree(const AskedRays& rays) const {
  Variants variants;
  for (const auto& [build, high] : kBuilds)
    for (const EmbreeQuery& way : world_.ways_to_trace())
      if (way.width > 1)
        variants.push_back({name_of(way) + build, [&rays, way, scene = casters(high)] {
                              uint8_t blocked[kWavefront];
                              for (const auto& [first, count] : rays.arrays)
                                occluded(scene, way, std::span(rays.segments).subspan(first, count), blocked);
                            }});
  return variants;
}

PathBench::Variants PathBench::wavefront_vcd(const AskedRays& rays) const {
  Variants variants;
  for (const PathWay& way : ways_)
    variants.push_back({way.name, [&rays, &way] {
                          uint64_t blocked[kWavefront / 64];
                          for (const AskedRays::Array& array : rays.arrays) way.paths.occluded(rays, array, blocked);
                        }});
  return variants;
}

namespace {

tools::Json describe(const PathTimes& times, uint64_t segments) {
  const Timing& best = fastest(times.embree);
  return {{"best_embree", best.name},
          {"embree", describe(times.embree, best, segments)},
          {"vcd", describe(times.vcd, best, segments)}};
}

}  // namespace

tools::Json describe(const PathComparison& c, const std::vector<PathWay>& ways) {
  tools::Json wrong;
  for (size_t w = 0; w < ways.size(); ++w) wrong[ways[w].name] = c.wrong[w];
  return {{"name", c.name},
          {"segments", c.segments},
          {"blocked", c.blocked},
          {"differ", c.differ},
          {"judged", c.judged},
          {"wrong_embree", c.wrong_embree},
          {"wrong", wrong},
          {"single_calls", describe(c.single, c.segments)},
          {"wavefronts", describe(c.wavefronts, c.segments)}};
}

}  // namespace vcd::bench
