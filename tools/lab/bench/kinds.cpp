#include "kinds.h"

#include <algorithm>

#include <vcd/baker/audit.h>

namespace vcd::bench {

using namespace baker;
using namespace tools;
using namespace render;

std::array<Recording, kSegmentKinds> split_by_kind(const World& world, const Recording& recording, uint64_t most,
                                                   std::array<uint64_t, kSegmentKinds>& all) {
  const auto visit_parts = [&](const auto& visit) {
    for (size_t i = 0; i < recording.size(); ++i) {
      struct Part {
        std::vector<Segment> segments;
        std::vector<float> u, v;
      };
      std::array<Part, kSegmentKinds> parts;
      const Bundle bundle = recording[i];
      for (size_t k = 0; k < bundle.segments.size(); ++k) {
        Part& part = parts[static_cast<size_t>(segment_kind(world, bundle.surface, bundle.segments[k]))];
        part.segments.push_back(bundle.segments[k]);
        part.u.push_back(bundle.u[k]), part.v.push_back(bundle.v[k]);
      }
      for (size_t k = 0; k < kSegmentKinds; ++k)
        if (!parts[k].segments.empty())
          visit(k, Bundle{parts[k].segments, parts[k].u, parts[k].v, bundle.light, bundle.pixel, bundle.surface,
                          bundle.primitive});
    }
  };
  all = {};
  visit_parts([&](size_t kind, const Bundle& part) { all[kind] += part.segments.size(); });
  std::array<Recording, kSegmentKinds> kinds;
  std::array<uint64_t, kSegmentKinds> seen{};
  visit_parts([&](size_t kind, const Bundle& part) {
    // Keep a bundle where the evenly growing quota has room for it.
    seen[kind] += part.segments.size();
    const double share = std::min(1.0, static_cast<double>(most) / static_cast<double>(all[kind]));
    if (static_cast<double>(kinds[kind].segment_count()) < share * static_cast<double>(seen[kind]))
      kinds[kind].append(part);
  });
  return kinds;
}

Json describe_seconds(const Timing& t, double scale) {
  return {{"median", t.median * scale}, {"minimum", t.minimum * scale}, {"maximum", t.maximum * scale}};
}

namespace {

// A caster's way through all bundles.
Variant timed(std::string name, const Recording& bundles, std::shared_ptr<ShadowCaster> caster) {
  return {std::move(name), [&bundles, caster] {
            uint8_t blocked[kMaxBundle];
            for (size_t i = 0; i < bundles.size(); ++i)
              caster->cast(bundles[i], std::span(blocked).first(bundles[i].segments.size()));
          }};
}

Variant timed_look_up(std::string name, const Recording& bundles, std::shared_ptr<SidecarShadows> caster) {
  return {std::move(name), [&bundles, caster] {
            Visibility answers[kMaxBundle];
            for (size_t i = 0; i < bundles.size(); ++i)
              caster->look_up(bundles[i], std::span(answers).first(bundles[i].segments.size()));
          }};
}

KindCounts count(const World& world, const Recording& bundles, const SidecarVariant& variant,
                 const TestCounter& counter, EmbreeQuery truth, Judge* judge) {
  size_t pixels = 0;
  for (size_t i = 0; i < bundles.size(); ++i) pixels = std::max<size_t>(pixels, bundles[i].pixel + size_t{1});
  Census census(world, *variant.objects, counter, truth, pixels, judge);
  const auto caster = census.caster();
  uint8_t blocked[kMaxBundle];
  for (size_t i = 0; i < bundles.size(); ++i)
    caster->cast(bundles[i], std::span(blocked).first(bundles[i].segments.size()));
  return census.take().total();
}

void learn(const World& world, const Recording& bundles, EmbreeQuery truth, Judge& judge) {
  uint8_t embree[kMaxBundle], exact[kMaxBundle];
  for (size_t i = 0; i < bundles.size(); ++i) {
    const auto segments = bundles[i].segments;
    occluded(world.shadow_casters(), truth, segments, embree);
    judge.learn(segments, std::span(embree).first(segments.size()), std::span(exact).first(segments.size()));
  }
}

}  // namespace

Json measure_kind(const World& world, SegmentKind kind, const Recording& bundles,
                  const std::vector<SidecarVariant>& variants, const TestCounter& counter, EmbreeQuery truth,
                  Judge* judge, int repetitions) {
  const std::vector<EmbreeQuery> ways = world.ways_to_trace();
  std::vector<Variant> runs;
  for (const EmbreeQuery& way : ways)
    runs.push_back(timed(name_of(way), bundles, std::make_shared<BvhShadows>(world, way)));
  for (const SidecarVariant& v : variants) {
    runs.push_back(timed_look_up(v.id, bundles, std::make_shared<SidecarShadows>(world, *v.objects, v.ways)));
    runs.push_back(timed(v.id, bundles, std::make_shared<SidecarShadows>(world, *v.objects, v.ways)));
    if (have_hierarchies(*v.objects))
      runs.push_back(timed(v.id + "-hierarchy", bundles, std::make_shared<HierarchyShadows>(world, *v.objects)));
  }
  const std::vector<Timing> timings = time_interleaved(runs, repetitions);
  if (judge) learn(world, bundles, truth, *judge);
  const double scale = 1e9 / static_cast<double>(bundles.segment_count());
  Json json{{"kind", segment_kind_name(kind)}, {"segments", bundles.segment_count()}};
  size_t best = 0;
  for (size_t w = 0; w < ways.size(); ++w) {
    json["embree"].push_back({{"name", timings[w].name}, {"ns", describe_seconds(timings[w], scale)}});
    if (timings[w].median < timings[best].median) best = w;
  }
  json["best_embree"] = timings[best].name;
  json["vcd"] = Json::array();
  auto timing = timings.begin() + static_cast<std::ptrdiff_t>(ways.size());
  for (const SidecarVariant& v : variants) {
    Json entry{{"variant", v.id}};
    entry["lookup_ns"] = describe_seconds(*timing++, scale);
    entry["ns"] = describe_seconds(*timing++, scale);
    if (have_hierarchies(*v.objects)) entry["hierarchy_ns"] = describe_seconds(*timing++, scale);
    entry.update(describe_counts(count(world, bundles, v, counter, truth, judge)));
    json["vcd"].push_back(entry);
  }
  return json;
}

Json describe_counts(const KindCounts& c) {
  return {{"segments", c.segments},
          {"resolved", c.resolved()},
          {"clear", c.answered[0]},
          {"blocked", c.answered[1]},
          {"wrong", c.wrong},
          {"wrong_resolved", c.wrong_answered},
          {"wrong_bound_95", upper_bound_95(c.wrong, c.segments)}};
}

}  // namespace vcd::bench
