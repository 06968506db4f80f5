// Arrays and bundles through a scene, a chunk at a time: whole beams through the hierarchy, runs of sixteen through the
// trees, and what stays unclassified by instance to the caller. See spec/proofs.md, "Scenes".
#include <algorithm>
#include <array>
#include <bit>
#include <cassert>

#include "beam/beam.h"
#include "hierarchy/fan.h"
#include "lookup/segment_columns.h"
#include "scene/beams.h"
#include "scene/bits_by_instance.h"
#include "scene/scene_state.h"
#include "scene/trace.h"
#include "scene/walk.h"

namespace vcd {
namespace {

// What is asked, the same for all chunks.
struct Asked {
  const Scene::State& scene;
  const SceneQuery& query;
  bool one_origin;                 // all segments begin at one point, on the query's first instance
  const TraceUnclassified* trace;  // null: look up only
  bool hierarchies = false;        // they are what is traced

  Begin begin(size_t segment) const { return begin_of(query, one_origin ? 0 : segment); }
  uint32_t self(size_t segment) const { return begin(segment).instance; }
  // Whether to look an instance up before it is traced.
  bool looks_up(uint32_t instance) const {
    return scene.data.look_ups[instance].tree && (!hierarchies || scene.data.instances[instance].look_up_bundles);
  }
  bool sees(uint32_t instance) const { return scene.data.instances[instance].mask & query.mask; }
};

// A chunk of segments on its way.
struct Chunk {
  size_t first, count;  // of the query's segments
  SampleBits all, blocked{};
  SampleBits unclassified{};       // where nothing is traced
  BitsByInstance<64> left;         // where something is: what waits to be traced
  BitsByInstance<kChunk> self;     // the segments that begin on an instance
  SegmentColumns<kChunk> columns;  // in the world
  SampleBits odd{};                // those that are not trusted: <trusted.h>

  Chunk(size_t first_, size_t count_) : first(first_), count(count_), all(SampleBits::first(count_)) {}
  SampleBits live() const { return all.without(blocked); }
};

void fill(SegmentColumns<kChunk>& columns, const QuadBundle& b, const BundleChunk& chunk) {
  const size_t count = chunk.runs() * kRun;
  for (int a = 0; a < 3; ++a) {
    const float corner = b.corner[a] - b.origin[a];
    for (size_t i = 0; i < count; ++i)
      columns.direction[a][i] = (corner + chunk.u[i] * b.edge_u[a]) + chunk.v[i] * b.edge_v[a];
  }
  columns.set_origin(b.origin, count);
}
void fill(SegmentColumns<kChunk>& columns, const SphereBundle& b, const BundleChunk& chunk) {
  const float* const ends[3] = {b.x.data() + chunk.first, b.y.data() + chunk.first, b.z.data() + chunk.first};
  for (int a = 0; a < 3; ++a)
    for (size_t i = 0; i < chunk.count; ++i) columns.direction[a][i] = ends[a][i] - b.origin[a];
  columns.set_origin(b.origin, chunk.count);
  columns.pad(chunk.count);
}

// The caller's own hierarchy is asked of one instance, in the world or in the object's frame.
void trace(const Asked& asked, Chunk& chunk, uint32_t instance, const SampleBits& bits, bool in_world) {
  if (!bits.any()) return;
  const SceneData& data = asked.scene.data;
  SegmentColumns<kChunk> columns;
  uint32_t indices[kChunk];
  size_t count = 0;
  for (size_t i : bits) {
    columns.set(count, segment_at(chunk.columns.view(i, 1), 0));
    indices[count++] = static_cast<uint32_t>(chunk.first + i);
  }
  const SegmentArrays runs = columns.view(0, columns.pad(count));
  if (!in_world && (bits & chunk.odd).any())
    for (size_t k = 0; k < runs.count; ++k) columns.set(k, *in_object(data, instance, segment_at(runs, k)));
  else if (!in_world)
    asked.scene.kernels->to_object(data.instances[instance].to_grid, data.instances[instance].to_frame, runs,
                                   {columns.origin[0], columns.origin[1], columns.origin[2]},
                                   {columns.direction[0], columns.direction[1], columns.direction[2]});
  uint8_t blocked[kChunk] = {};
  (*asked.trace)({instance, columns.view(0, count), indices, blocked, in_world});
  for (size_t k = 0; k < count; ++k) chunk.blocked.set(indices[k] - chunk.first, blocked[k] != 0);
}

// ask() of segments of a bundle that are trusted, in the frame of an instance's object.
template <class Ask>
SampleBits ask_object(const Scene::State& scene, const Chunk& chunk, uint32_t instance, const SampleBits& bits,
                      const Ask& ask) {
  const InstanceData& placed = scene.data.instances[instance];
  SegmentColumns<kChunk> moved;
  for (size_t r = 0; r * kRun < chunk.count; ++r)
    if (const size_t at = r * kRun; bits.run(r) != 0)
      scene.kernels->to_object(placed.to_grid, placed.to_frame, chunk.columns.view(at, kRun),
                               {moved.origin[0] + at, moved.origin[1] + at, moved.origin[2] + at},
                               {moved.direction[0] + at, moved.direction[1] + at, moved.direction[2] + at});
  const size_t some = bits.lowest();
  return ask(Fan{{moved.origin[0][some], moved.origin[1][some], moved.origin[2][some]},
                 {moved.direction[0], moved.direction[1], moved.direction[2]},
                 chunk.count,
                 bits});
}

// Those that the object's own hierarchy blocks.
SampleBits blocked_by_object(const Scene::State& scene, const Chunk& chunk, uint32_t instance, const SampleBits& bits) {
  const ObjectData& object = traced_object(scene.data, instance);
  return ask_object(scene, chunk, instance, bits,
                    [&](const Fan& fan) { return object.trace->fan(object.traced, fan); });
}

// In the object's frame where that can hold the segments.
void trace(const Asked& asked, Chunk& chunk, uint32_t instance, const SampleBits& bits) {
  SampleBits in_world{};
  if (has_inverse(asked.scene.data.instances[instance].to_grid)) {
    for (size_t i : bits& chunk.odd)
      if (!in_object(asked.scene.data, instance, segment_at(chunk.columns.view(i, 1), 0))) in_world.set(i);
  } else {
    in_world = bits;
  }
  // Those that are not trusted by themselves: they move in doubles, and their origins may come to lie a bit elsewhere.
  const SampleBits moved = bits.without(in_world), usual = moved.without(chunk.odd);
  if (!asked.hierarchies) trace(asked, chunk, instance, usual, false);
  else if (usual.any()) chunk.blocked |= blocked_by_object(asked.scene, chunk, instance, usual);
  trace(asked, chunk, instance, moved & chunk.odd, false);
  trace(asked, chunk, instance, in_world, true);
}

// All that waits.
void trace_left(const Asked& asked, Chunk& chunk) {
  if (!asked.trace) chunk.unclassified = chunk.unclassified.without(chunk.blocked);
  chunk.left.take(
      [&](uint32_t instance, const SampleBits& bits) { trace(asked, chunk, instance, bits.without(chunk.blocked)); });
}

// Nothing is known of these segments and the instance.
void leave(const Asked& asked, Chunk& chunk, uint32_t instance, const SampleBits& of) {
  const SampleBits bits = of.without(chunk.blocked);
  if (!bits.any() || !asked.sees(instance)) return;
  if (!asked.trace) {
    chunk.unclassified |= bits;
  } else if (!chunk.left.add(instance, bits)) {
    trace_left(asked, chunk);
    chunk.left.add(instance, bits.without(chunk.blocked));
  }
}

// visit(instance) for those that the beam could meet, until all is blocked.
template <class Visit>
void walk_beam(const Asked& asked, const Chunk& chunk, const SceneBeam& beam, const Visit& visit) {
  walk(
      asked.scene.data, asked.query.mask,
      [&](const SceneNode& node) { return asked.scene.kernels->boxes_in_beam(node, beam); },
      [&] { return !chunk.live().any(); }, visit);
}

// Runs in which something is not blocked yet, looked up in one instance.
void look_up_runs(const Asked& asked, Chunk& chunk, uint32_t instance, size_t first_run, size_t runs) {
  SampleAnswers answers;
  const SampleBits now = chunk.live();
  const LookUp& object = asked.scene.data.look_ups[instance];
  for (size_t r = first_run; r < first_run + runs;) {
    if (now.run(r) == 0) {
      ++r;
      continue;
    }
    size_t end = r + 1;
    while (end < first_run + runs && now.run(end) != 0) ++end;
    const size_t begin = r * kRun, count = (end - r) * kRun;
    Visibility found[kChunk];
    if (asked.looks_up(instance))
      object.kernels->placed(asked.scene.data.instances[instance].to_grid, *object.tree,
                             chunk.columns.view(begin, count), found);
    else std::fill_n(found, count, Visibility::unclassified);
    for (size_t i = 0; i < count; ++i) answers.set(begin + i, found[i]);
    r = end;
  }
  const SampleBits asked_now = now.without(chunk.self.of(instance));  // the others were asked before
  answers.blocked &= asked_now, answers.unclassified &= asked_now;
  chunk.blocked |= answers.blocked;
  leave(asked, chunk, instance, answers.unclassified);
}

// Runs of trusted segments as one beam through the hierarchy; false if they have too little in common.
bool run_together(const Asked& asked, Chunk& chunk, size_t first_run, size_t runs) {
  const auto beam = beam_of(chunk.columns, first_run * kRun, runs * kRun);
  if (!beam) return false;
  walk_beam(asked, chunk, *beam, [&](uint32_t instance) { look_up_runs(asked, chunk, instance, first_run, runs); });
  return true;
}

// A run's segments one by one through the hierarchy.
void run_alone(const Asked& asked, Chunk& chunk, std::span<const Segment> segments, size_t r) {
  const size_t first = r * kRun, count = std::min(kRun, chunk.count - first);
  std::array<UnclassifiedPair, 1024> pairs;
  std::array<Visibility, kRun> answers;
  std::array<uint32_t, kRun> self;
  answers.fill(Visibility::clear);
  for (size_t k = 0; k < count; ++k) self[k] = asked.self(chunk.first + first + k);
  UnclassifiedList list{pairs};
  const SceneQuery query{asked.query.mask, std::span(self).first(count)};
  asked.scene.kernels->scene_segments(asked.scene.data, segments.subspan(first, count), query, {answers.data(), &list});
  SampleAnswers found;
  for (size_t k = 0; k < count; ++k) found.set(first + k, answers[k]);
  chunk.blocked |= found.blocked;
  if (!list.complete) {
    for (uint32_t i = 0; i < asked.scene.instances.size(); ++i) leave(asked, chunk, i, found.unclassified);
    return;
  }
  for (size_t k = 0; k < list.count; ++k)
    if (const UnclassifiedPair& p = pairs[k]; p.instance != self[p.segment])
      leave(asked, chunk, p.instance, SampleBits::just(first + p.segment));
}

// Which segments begin on which instance.
void find_self(const Asked& asked, Chunk& chunk) {
  for (size_t i = 0; i < chunk.count && !asked.query.origins.empty();) {
    const uint32_t instance = asked.self(chunk.first + i);
    SampleBits bits{};
    for (; i < chunk.count && asked.self(chunk.first + i) == instance; ++i) bits.set(i);
    if (instance != kNoInstance) chunk.self.add(instance, bits);
  }
}

// Of the segments that begin on an instance, those that its horizons prove clear of it.
SampleBits clear_of_self(const Asked& asked, const Chunk& chunk, uint32_t instance, const SampleBits& bits) {
  const InstanceData& placed = asked.scene.data.instances[instance];
  if (asked.query.primitives.empty() || !placed.object || !placed.object->horizons.view) return {};
  if (asked.one_origin && !(bits & chunk.odd).any() && has_inverse(placed.to_grid))
    return ask_object(asked.scene, chunk, instance, bits, [&](const Fan& fan) {
      return placed.object->horizon->fan(placed.object->horizons, fan, asked.begin(0).primitive);
    });
  SampleBits clear{};
  for (size_t i : bits)
    clear.set(
        i, vcd::clear_of_self(asked.scene.data, asked.begin(chunk.first + i), segment_at(chunk.columns.view(i, 1), 0)));
  return clear;
}

// At most kChunk segments.
void answer(const Asked& asked, Chunk& chunk, std::span<const Segment> segments) {
  for (size_t i = 0; i < chunk.count; ++i) chunk.columns.set(i, segments[i]);
  if (!are_trusted(chunk.columns, chunk.count))
    for (size_t i = 0; i < chunk.count; ++i) chunk.odd.set(i, !is_trusted(segments[i]));
  const size_t runs = chunk.columns.pad(chunk.count) / kRun;
  find_self(asked, chunk);
  chunk.self.for_each([&](uint32_t instance, const SampleBits& bits) {
    leave(asked, chunk, instance, bits.without(clear_of_self(asked, chunk, instance, bits)));
  });
  trace_left(asked, chunk);
  if (chunk.odd.any() || !run_together(asked, chunk, 0, runs))
    for (size_t r = 0; r < runs; ++r)
      if (chunk.live().run(r) != 0 && (runs == 1 || chunk.odd.run(r) != 0 || !run_together(asked, chunk, r, 1)))
        run_alone(asked, chunk, segments, r);
  trace_left(asked, chunk);
}

// The frame is usable, the samples placed, measured and trusted.
template <class Bundle>
void answer(const Asked& asked, Chunk& chunk, const Bundle& bundle, const BeamFrame& frame,
            const BundleChunk& samples) {
  fill(chunk.columns, bundle, samples);
  const uint32_t self = asked.self(0);
  if (self != kNoInstance)
    leave(asked, chunk, self, chunk.all.without(clear_of_self(asked, chunk, self, chunk.all))),
        trace_left(asked, chunk);
  const SceneData& data = asked.scene.data;
  const float* const directions[3] = {chunk.columns.direction[0], chunk.columns.direction[1],
                                      chunk.columns.direction[2]};
  walk_beam(asked, chunk, beam_of(frame, samples), [&](uint32_t instance) {
    if (instance == self) return;
    const LookUp& object = data.look_ups[instance];
    const ToGrid& grid = data.instances[instance].to_grid;
    SampleAnswers answers{{}, chunk.live()};
    if (asked.looks_up(instance) && near_enough(grid, frame, samples)) {
      answers.unclassified = {};
      asked.scene.kernels->scene_bundle(object, {grid, frame, samples, chunk.live().runs(), directions}, answers);
    }
    chunk.blocked |= answers.blocked;
    leave(asked, chunk, instance, answers.unclassified);
  });
  trace_left(asked, chunk);
}

template <class Bundle>
void run_bundle(const Asked& asked, const Bundle& bundle, std::span<uint64_t> blocked,
                std::span<uint64_t> unclassified) {
  assert(fits(bundle, blocked) && (asked.trace || fits(bundle, unclassified)));
  const BeamFrame frame = beam_frame(bundle);
  BundleChunk samples;
  for (samples.first = 0; samples.first < bundle.size(); samples.first += kChunk) {
    samples.count = std::min(kChunk, bundle.size() - samples.first);
    place(bundle, frame, samples);
    asked.scene.kernels->measure(samples);
    set_size(frame, samples);
    Chunk chunk(samples.first, samples.count);
    if (frame.usable && is_trusted(frame, samples)) {
      answer(asked, chunk, bundle, frame, samples);
    } else {
      std::array<Segment, kChunk> segments;
      for (size_t i = 0; i < samples.count; ++i) segments[i] = segment_of(bundle, samples.first + i);
      answer(asked, chunk, std::span<const Segment>(segments).first(samples.count));
    }
    chunk.blocked.store(chunk.count, blocked.data() + chunk.first / 64);
    if (!asked.trace) chunk.unclassified.store(chunk.count, unclassified.data() + chunk.first / 64);
  }
}

void run_points(const Asked& asked, const PointBundle& bundle, std::span<uint64_t> blocked) {
  assert(fits(bundle, blocked));
  std::array<Segment, kChunk> segments;
  for (size_t first = 0; first < bundle.size(); first += kChunk) {
    Chunk chunk(first, std::min(kChunk, bundle.size() - first));
    for (size_t i = 0; i < chunk.count; ++i) segments[i] = segment_of(bundle, first + i);
    answer(asked, chunk, std::span<const Segment>(segments).first(chunk.count));
    chunk.blocked.store(chunk.count, blocked.data() + first / 64);
  }
}

// The objects' own hierarchies in the place of the caller's, for bundles: all segments begin at one point, with t from
// 0 to 1.
class HierarchyTrace {
 public:
  explicit HierarchyTrace(const SceneData& scene) : scene_(scene) {}

  void operator()(const UnclassifiedSegments& left) const {
    const ObjectData& object = traced_object(scene_, left.instance);
    const SegmentArrays& s = left.segments;
    const SampleBits all = SampleBits::first(s.count);
    SampleBits blocked{};
    if (left.in_world) {
      for (size_t i : all)
        blocked.set(i, blocks_in_world(object.traced.view, scene_.to_world[left.instance], segment_at(s, i)));
    } else {
      blocked = object.trace->fan(object.traced, {{s.origin[0][0], s.origin[1][0], s.origin[2][0]},
                                                  {s.direction[0], s.direction[1], s.direction[2]},
                                                  s.count,
                                                  all});
    }
    for (size_t i : blocked) left.blocked[i] = 1;
  }

 private:
  const SceneData& scene_;
};

void run_array(const Asked& asked, std::span<const Segment> segments, std::span<uint64_t> blocked) {
  assert(has_words_for(segments.size(), blocked));
  for (size_t first = 0; first < segments.size(); first += kChunk) {
    Chunk chunk(first, std::min(kChunk, segments.size() - first));
    answer(asked, chunk, segments.subspan(first, chunk.count));
    chunk.blocked.store(chunk.count, blocked.data() + first / 64);
  }
}

}  // namespace

void Scene::occluded(std::span<const Segment> segments, std::span<uint64_t> blocked,
                     const SceneQuery& query) const noexcept {
  assert(has_words_for(segments.size(), blocked));
  for (size_t first = 0; first < segments.size(); first += kChunk) {
    const size_t count = std::min(kChunk, segments.size() - first);
    const SceneQuery part{query.mask, query.origins.subspan(std::min(first, query.origins.size())),
                          query.primitives.subspan(std::min(first, query.primitives.size()))};
    state_->kernels->occluded_array_in_scene(state_->data, segments.subspan(first, count), part)
        .store(count, blocked.data() + first / 64);
  }
}
void Scene::occluded(const QuadBundle& bundle, std::span<uint64_t> blocked, const SceneQuery& query) const noexcept {
  const HierarchyTrace hierarchies(state_->data);
  const TraceUnclassified trace(hierarchies);
  run_bundle({*state_, query, true, &trace, true}, bundle, blocked, {});
}
void Scene::occluded(const SphereBundle& bundle, std::span<uint64_t> blocked, const SceneQuery& query) const noexcept {
  const HierarchyTrace hierarchies(state_->data);
  const TraceUnclassified trace(hierarchies);
  run_bundle({*state_, query, true, &trace, true}, bundle, blocked, {});
}
void Scene::occluded(const PointBundle& bundle, std::span<uint64_t> blocked, const SceneQuery& query) const noexcept {
  const HierarchyTrace hierarchies(state_->data);
  const TraceUnclassified trace(hierarchies);
  run_points({*state_, query, true, &trace, true}, bundle, blocked);
}

void Scene::occluded(std::span<const Segment> segments, std::span<uint64_t> blocked, TraceUnclassified trace,
                     const SceneQuery& query) const {
  run_array({*state_, query, false, &trace}, segments, blocked);
}

void Scene::occluded(const QuadBundle& bundle, std::span<uint64_t> blocked, TraceUnclassified trace,
                     const SceneQuery& query) const {
  run_bundle({*state_, query, true, &trace}, bundle, blocked, {});
}
void Scene::occluded(const SphereBundle& bundle, std::span<uint64_t> blocked, TraceUnclassified trace,
                     const SceneQuery& query) const {
  run_bundle({*state_, query, true, &trace}, bundle, blocked, {});
}
void Scene::occluded(const PointBundle& bundle, std::span<uint64_t> blocked, TraceUnclassified trace,
                     const SceneQuery& query) const {
  run_points({*state_, query, true, &trace}, bundle, blocked);
}

void Scene::classify(const QuadBundle& bundle, std::span<uint64_t> blocked, std::span<uint64_t> unclassified,
                     const SceneQuery& query) const noexcept {
  run_bundle({*state_, query, true, nullptr}, bundle, blocked, unclassified);
}
void Scene::classify(const SphereBundle& bundle, std::span<uint64_t> blocked, std::span<uint64_t> unclassified,
                     const SceneQuery& query) const noexcept {
  run_bundle({*state_, query, true, nullptr}, bundle, blocked, unclassified);
}

}  // namespace vcd
