// Many segments through a scene: whole beams through the hierarchy, runs of sixteen through the trees, and what is left
// open by instance to the caller. See spec/proofs.md, "Scenes".
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "beam.h"
#include "bits.h"
#include "scene_state.h"

namespace vcd {
namespace {

constexpr size_t kChunkWords = kBundleChunk / 64;
using Bits = std::array<uint64_t, kChunkWords>;

// The first `count` of them.
Bits first_bits(size_t count) {
  Bits bits{};
  for (size_t w = 0; w < kChunkWords && 64 * w < count; ++w)
    bits[w] = bits_from(0, std::min<size_t>(64, count - 64 * w));
  return bits;
}
bool any_of(const Bits& bits) {
  return std::any_of(bits.begin(), bits.end(), [](uint64_t w) { return w != 0; });
}
int count_of(const Bits& bits) {
  int sum = 0;
  for (uint64_t w : bits) sum += std::popcount(w);
  return sum;
}
Bits without(Bits a, const Bits& b) {
  for (size_t w = 0; w < kChunkWords; ++w) a[w] &= ~b[w];
  return a;
}
void add(Bits& a, const Bits& b) {
  for (size_t w = 0; w < kChunkWords; ++w) a[w] |= b[w];
}
uint64_t run_of(const Bits& bits, size_t r) { return bits[r * kRun / 64] >> (r * kRun % 64) & 0xFFFF; }
uint32_t runs_of(const Bits& bits) {
  uint32_t runs = 0;
  for (size_t r = 0; r < kRuns; ++r) runs |= uint32_t{run_of(bits, r) != 0} << r;
  return runs;
}
template <class Visit>
void for_each_bit(const Bits& bits, const Visit& visit) {
  for (size_t w = 0; w < kChunkWords; ++w)
    for (uint64_t left = bits[w]; left; left &= left - 1) visit(64 * w + static_cast<size_t>(std::countr_zero(left)));
}

// At most kBundleChunk segments as structure of arrays; from the last real one to a multiple of kRun its copies.
struct Columns {
  alignas(64) float origin[3][kBundleChunk], direction[3][kBundleChunk], t_min[kBundleChunk], t_max[kBundleChunk];

  SegmentArrays view(size_t first, size_t count) const {
    return {{origin[0] + first, origin[1] + first, origin[2] + first},
            t_min + first,
            {direction[0] + first, direction[1] + first, direction[2] + first},
            t_max + first,
            count};
  }
  void set(size_t i, const Segment& s) {
    for (int a = 0; a < 3; ++a) origin[a][i] = s.origin[a], direction[a][i] = s.direction[a];
    t_min[i] = s.t_min, t_max[i] = s.t_max;
  }
  void set(const QuadBundle& b, const BundleChunk& chunk) {
    const size_t count = chunk.runs() * kRun;
    for (int a = 0; a < 3; ++a) {
      const float corner = b.corner[a] - b.origin[a];
      for (size_t i = 0; i < count; ++i)
        direction[a][i] = (corner + chunk.u[i] * b.edge_u[a]) + chunk.v[i] * b.edge_v[a];
    }
    set_origin(b.origin, count);
  }
  void set(const SphereBundle& b, const BundleChunk& chunk) {
    const float* const ends[3] = {b.x.data() + chunk.first, b.y.data() + chunk.first, b.z.data() + chunk.first};
    for (int a = 0; a < 3; ++a)
      for (size_t i = 0; i < chunk.count; ++i) direction[a][i] = ends[a][i] - b.origin[a];
    set_origin(b.origin, chunk.count);
    pad(chunk.count);
  }
  void set_origin(const float (&from)[3], size_t count) {
    for (int a = 0; a < 3; ++a) std::fill_n(origin[a], count, from[a]);
    std::fill_n(t_min, count, 0.0f);
    std::fill_n(t_max, count, 1.0f);
  }
  void copy(size_t from, size_t to) {
    for (int a = 0; a < 3; ++a) origin[a][to] = origin[a][from], direction[a][to] = direction[a][from];
    t_min[to] = t_min[from], t_max[to] = t_max[from];
  }
  void pad(size_t count) {
    for (size_t i = count; i % kRun != 0; ++i) copy(count - 1, i);
  }
};

// Segments of a chunk by instance: what is left open, or where they begin.
template <size_t kMost>
class BitsByInstance {
 public:
  void clear() { count_ = 0; }
  // False if there is no room for another instance.
  bool add_to(uint32_t instance, const Bits& bits) {
    if (const size_t k = find(instance); k < count_) return add(bits_[k], bits), true;
    if (count_ == kMost) return false;
    instances_[count_] = instance, bits_[count_++] = bits;
    return true;
  }
  Bits of(uint32_t instance) const {
    const size_t k = find(instance);
    return k < count_ ? bits_[k] : Bits{};
  }
  template <class Visit>
  void for_each(const Visit& visit) const {
    for (size_t k = 0; k < count_; ++k) visit(instances_[k], bits_[k]);
  }
  // visit(instance, bits), those with most bits first; then there are none.
  template <class Visit>
  void take(const Visit& visit) {
    std::array<std::pair<int, uint32_t>, kMost> order;
    for (uint32_t k = 0; k < count_; ++k) order[k] = {-count_of(bits_[k]), k};
    std::sort(order.begin(), order.begin() + count_);
    for (size_t k = 0; k < count_; ++k) visit(instances_[order[k].second], bits_[order[k].second]);
    count_ = 0;
  }

 private:
  size_t find(uint32_t instance) const {
    return static_cast<size_t>(
        std::find(instances_.begin(), instances_.begin() + static_cast<std::ptrdiff_t>(count_), instance) -
        instances_.begin());
  }

  std::array<uint32_t, kMost> instances_;
  std::array<Bits, kMost> bits_;
  size_t count_ = 0;
};

void set_bound(float direction, float& inverse) {
  inverse = 1 / std::copysign(std::max(std::abs(direction), 1e-37f), direction);
}

// A chunk of segments on its way.
class Chunk {
 public:
  // one_origin: all segments begin on the query's first. trace: null to look up only.
  Chunk(const Scene::State& state, const SceneQuery& query, bool one_origin, const TraceOpen* trace)
      : scene_(state), query_(query), one_origin_(one_origin), trace_(trace) {}

  // segments: at most kBundleChunk, the first of them number `first` of the query.
  void run(std::span<const Segment> segments, size_t first) {
    start(segments.size(), first);
    for (size_t i = 0; i < count_; ++i) columns_.set(i, segments[i]);
    columns_.pad(count_);
    find_origins();
    origins_.for_each([&](uint32_t instance, const Bits& bits) { leave_open(instance, bits); });
    trace_open();
    const size_t runs = (count_ + kRun - 1) / kRun;
    if (!run_together(0, runs))
      for (size_t r = 0; r < runs; ++r)
        if (run_of(live(), r) != 0 && (runs == 1 || !run_together(r, 1))) run_alone(segments, r);
    trace_open();
  }

  // The frame is usable, the chunk placed and finite.
  template <class Bundle>
  void run(const Bundle& bundle, const BeamFrame& frame, const BundleChunk& chunk) {
    start(chunk.count, chunk.first);
    columns_.set(bundle, chunk);
    const uint32_t own = origin_of(0);
    if (own != kNoInstance) leave_open(own, all_), trace_open();
    walk(beam_of(frame, chunk), [&](uint32_t instance) {
      if (instance == own) return;
      const ObjectData* object = scene_.data.objects[instance];
      const ToGrid& grid = scene_.data.to_grid[instance];
      Bits open = live();
      if (object && near_enough(grid, frame, chunk)) {
        Bits blocked{};
        open = {};
        const float* const directions[3] = {columns_.direction[0], columns_.direction[1], columns_.direction[2]};
        scene_.kernels.bundle(*object, grid, frame, chunk, runs_of(live()), directions, blocked.data(), open.data());
        add(blocked_, blocked);
      }
      leave_open(instance, open);
    });
    trace_open();
  }

  const Bits& blocked() const { return blocked_; }
  const Bits& open() const { return open_; }  // if there is no trace
  void put(const Bits& bits, std::span<uint64_t> into) const {
    std::copy_n(bits.begin(), (count_ + 63) / 64, into.begin() + static_cast<std::ptrdiff_t>(first_ / 64));
  }

 private:
  void start(size_t count, size_t first) {
    count_ = count, first_ = first;
    all_ = first_bits(count);
    blocked_ = {}, open_ = {};
  }
  Bits live() const { return without(all_, blocked_); }
  static Bits one(size_t i) {
    Bits bits{};
    bits[i / 64] = uint64_t{1} << (i % 64);
    return bits;
  }
  // origins_: a run of segments that begin on the same instance at a time.
  void find_origins() {
    origins_.clear();
    for (size_t i = 0; i < count_ && !query_.origins.empty();) {
      const uint32_t instance = origin_of(i);
      Bits bits{};
      for (; i < count_ && origin_of(i) == instance; ++i) bits[i / 64] |= uint64_t{1} << (i % 64);
      if (instance != kNoInstance) origins_.add_to(instance, bits);
    }
  }
  uint32_t origin_of(size_t i) const {
    const size_t at = one_origin_ ? 0 : first_ + i;
    return at < query_.origins.size() ? query_.origins[at] : kNoInstance;
  }

  void leave_open(uint32_t instance, Bits bits) {
    bits = without(bits, blocked_);
    if (!any_of(bits) || !(scene_.data.masks[instance] & query_.mask)) return;
    if (!trace_) return add(open_, bits);
    if (instances_.add_to(instance, bits)) return;
    trace_open();
    instances_.add_to(instance, without(bits, blocked_));
  }

  void trace_open() {
    if (!trace_) open_ = without(open_, blocked_);
    instances_.take([&](uint32_t instance, const Bits& bits) { trace(instance, without(bits, blocked_)); });
  }

  void trace(uint32_t instance, const Bits& bits) {
    if (!any_of(bits)) return;
    Columns world;
    uint32_t indices[kBundleChunk];
    size_t count = 0;
    for_each_bit(bits, [&](size_t i) {
      for (int a = 0; a < 3; ++a)
        world.origin[a][count] = columns_.origin[a][i], world.direction[a][count] = columns_.direction[a][i];
      world.t_min[count] = columns_.t_min[i], world.t_max[count] = columns_.t_max[i];
      indices[count++] = static_cast<uint32_t>(first_ + i);
    });
    world.pad(count);
    const size_t whole = (count + kRun - 1) / kRun * kRun;
    scene_.kernels.to_object(scene_.data.to_grid[instance], scene_.data.to_frame[instance], world.view(0, whole),
                             {world.origin[0], world.origin[1], world.origin[2]},
                             {world.direction[0], world.direction[1], world.direction[2]});
    uint8_t blocked[kBundleChunk] = {};
    (*trace_)({instance, world.view(0, count), indices, blocked});
    for (size_t k = 0; k < count; ++k) {
      const size_t i = indices[k] - first_;
      blocked_[i / 64] |= uint64_t{blocked[k] != 0} << (i % 64);
    }
  }

  // visit(instance) for those that the beam could meet, until all is blocked.
  template <class Visit>
  void walk(const SceneBeam& beam, const Visit& visit) {
    const SceneData& data = scene_.data;
    uint32_t waiting[kDeepest];
    size_t count = 0;
    if (!data.nodes.empty()) waiting[count++] = 0;
    while (count > 0 && any_of(live())) {
      const SceneNode& node = data.nodes[waiting[--count]];
      for (uint32_t met = scene_.kernels.boxes_in_beam(node, beam); met; met &= met - 1) {
        const uint32_t child = node.child[std::countr_zero(met)], instance = child & ~kLeaf;
        if (!(child & kLeaf)) waiting[count++] = child;
        else if (data.masks[instance] & query_.mask) visit(instance);
      }
    }
  }

  static SceneBeam beam_of(const BeamFrame& frame, const BundleChunk& chunk) {
    const Extent u = chunk.u_extent, v = chunk.v_extent;
    SceneBeam beam;
    for (int a = 0; a < 3; ++a) {
      const float ends[4] = {u.low * frame.edge_u[a], u.high * frame.edge_u[a], v.low * frame.edge_v[a],
                             v.high * frame.edge_v[a]};
      // Rounding of the directions, and of u and v where they were computed.
      const float slack = kBoxSlack * size_of(frame, chunk, a);
      beam.origin_low[a] = beam.origin_high[a] = frame.origin[a];
      set_bound(frame.corner[a] + std::min(ends[0], ends[1]) + std::min(ends[2], ends[3]) - slack, beam.inverse_low[a]);
      set_bound(frame.corner[a] + std::max(ends[0], ends[1]) + std::max(ends[2], ends[3]) + slack,
                beam.inverse_high[a]);
    }
    beam.t_max = static_cast<float>(frame.reach) * (1 + kBoxSlack);
    return beam;
  }

  // What rounding of the segments' directions does in an instance's grid.
  static bool near_enough(const ToGrid& grid, const BeamFrame& frame, const BundleChunk& chunk) {
    float sum = 0;
    for (int a = 0; a < 3; ++a) sum += grid.column[a][3] * size_of(frame, chunk, a);
    return sum * static_cast<float>(frame.reach) <= kFarthestReach;
  }

  // The segments of some runs as one beam; false if they have too little in common, or begin before t = 0.
  bool run_together(size_t first_run, size_t runs) {
    const size_t first = first_run * kRun, count = runs * kRun;
    SceneBeam beam;
    float spread = 0, length = 0, origin_spread = 0, t_min = columns_.t_min[first], sum = 0;
    bool numbers = true;
    beam.t_max = columns_.t_max[first];
    for (size_t i = first; i < first + count; ++i) {
      t_min = std::min(t_min, columns_.t_min[i]), beam.t_max = std::max(beam.t_max, columns_.t_max[i]);
      sum += columns_.t_min[i] * 0;
      numbers &= !std::isnan(columns_.t_max[i]);
    }
    for (int a = 0; a < 3; ++a) {
      const float *o = columns_.origin[a] + first, *d = columns_.direction[a] + first;
      float o_low = o[0], o_high = o[0], d_low = d[0], d_high = d[0];
      for (size_t i = 0; i < count; ++i) {
        o_low = std::min(o_low, o[i]), o_high = std::max(o_high, o[i]);
        d_low = std::min(d_low, d[i]), d_high = std::max(d_high, d[i]);
        sum += (o[i] + d[i]) * 0;
      }
      beam.origin_low[a] = o_low, beam.origin_high[a] = o_high;
      set_bound(d_low, beam.inverse_low[a]), set_bound(d_high, beam.inverse_high[a]);
      spread += d_high - d_low, length += std::max(std::abs(d_low), std::abs(d_high)), origin_spread += o_high - o_low;
    }
    constexpr float kCoherent = 0.25f;
    if (!(numbers && sum == 0 && t_min >= 0 && spread <= kCoherent * length &&
          origin_spread <= kCoherent * length * beam.t_max))
      return false;
    walk(beam, [&](uint32_t instance) { look_up_runs(instance, first_run, runs); });
    return true;
  }

  // Those in which something is not blocked.
  void look_up_runs(uint32_t instance, size_t first_run, size_t runs) {
    Bits open{}, blocked{};
    const Bits now = live();
    for (size_t r = first_run; r < first_run + runs;) {
      if (run_of(now, r) == 0) {
        ++r;
        continue;
      }
      size_t end = r + 1;
      while (end < first_run + runs && run_of(now, end) != 0) ++end;
      if (const ObjectData* object = scene_.data.objects[instance]) {
        Visibility answers[kBundleChunk];
        object->many.placed(*object, scene_.data.to_grid[instance], columns_.view(r * kRun, (end - r) * kRun), answers);
        for (size_t i = r * kRun; i < end * kRun; ++i) set_bits(answers[i - r * kRun], i, blocked.data(), open.data());
      } else {
        for (size_t i = r * kRun; i < end * kRun; ++i)
          set_bits(Visibility::unclassified, i, blocked.data(), open.data());
      }
      r = end;
    }
    const Bits asked = without(now, origins_.of(instance));  // the others were asked before
    for (size_t w = 0; w < kChunkWords; ++w) blocked_[w] |= blocked[w] & asked[w], open[w] &= asked[w];
    leave_open(instance, open);
  }

  // A run's segments one by one through the hierarchy.
  void run_alone(std::span<const Segment> segments, size_t r) {
    const size_t first = r * kRun, count = std::min(kRun, count_ - first);
    std::array<OpenPair, 1024> pairs;
    std::array<Visibility, kRun> answers;
    std::array<uint32_t, kRun> origins;
    answers.fill(Visibility::clear);
    for (size_t k = 0; k < count; ++k) origins[k] = origin_of(first + k);
    OpenSink sink{pairs};
    const SceneQuery query{query_.mask, std::span(origins).first(count)};
    scene_.kernels.segments(scene_.data, segments.subspan(first, count), query, {answers.data(), &sink});
    for (size_t k = 0; k < count; ++k)
      if (answers[k] == Visibility::blocked) add(blocked_, one(first + k));
    if (!sink.complete) {
      Bits unknown{};
      for (size_t k = 0; k < count; ++k)
        if (answers[k] == Visibility::unclassified) add(unknown, one(first + k));
      for (uint32_t i = 0; i < scene_.instances.size(); ++i) leave_open(i, unknown);
      return;
    }
    for (size_t k = 0; k < sink.count; ++k)
      if (const OpenPair& p = pairs[k]; p.instance != origin_of(first + p.segment))
        leave_open(p.instance, one(first + p.segment));
  }

  const Scene::State& scene_;
  const SceneQuery& query_;
  const bool one_origin_;
  const TraceOpen* trace_;
  size_t count_ = 0, first_ = 0;
  Bits all_, blocked_, open_;
  BitsByInstance<64> instances_;
  BitsByInstance<kBundleChunk> origins_;
  Columns columns_;
};

// Twice the size, for what is computed of it.
bool is_finite(const BeamFrame& frame, const BundleChunk& chunk) {
  float sum = 0;
  for (int a = 0; a < 3; ++a) sum += std::abs(frame.origin[a]) + 2 * size_of(frame, chunk, a);
  return std::isfinite(sum);
}

template <class Bundle>
void run_bundle(const Scene::State& state, const Bundle& bundle, const SceneQuery& query, const TraceOpen* trace,
                std::span<uint64_t> blocked, std::span<uint64_t> open) {
  const BeamFrame frame = beam_frame(bundle);
  Chunk chunk(state, query, true, trace);
  BundleChunk samples;
  for (samples.first = 0; samples.first < bundle.size(); samples.first += kBundleChunk) {
    samples.count = std::min(kBundleChunk, bundle.size() - samples.first);
    place(bundle, frame, samples);
    state.kernels.measure(samples);
    if (frame.usable && is_finite(frame, samples)) {
      chunk.run(bundle, frame, samples);
    } else {
      std::array<Segment, kBundleChunk> segments;
      for (size_t i = 0; i < samples.count; ++i) segments[i] = segment_of(bundle, samples.first + i);
      chunk.run(std::span(segments).first(samples.count), samples.first);
    }
    chunk.put(chunk.blocked(), blocked);
    if (!trace) chunk.put(chunk.open(), open);
  }
}

}  // namespace

void Scene::occluded(std::span<const Segment> segments, std::span<uint64_t> blocked, TraceOpen trace,
                     const SceneQuery& query) const {
  Chunk chunk(*state_, query, false, &trace);
  for (size_t first = 0; first < segments.size(); first += kBundleChunk) {
    chunk.run(segments.subspan(first, std::min(kBundleChunk, segments.size() - first)), first);
    chunk.put(chunk.blocked(), blocked);
  }
}

void Scene::occluded(const QuadBundle& bundle, std::span<uint64_t> blocked, TraceOpen trace,
                     const SceneQuery& query) const {
  run_bundle(*state_, bundle, query, &trace, blocked, {});
}
void Scene::occluded(const SphereBundle& bundle, std::span<uint64_t> blocked, TraceOpen trace,
                     const SceneQuery& query) const {
  run_bundle(*state_, bundle, query, &trace, blocked, {});
}
void Scene::classify(const QuadBundle& bundle, std::span<uint64_t> blocked, std::span<uint64_t> open,
                     const SceneQuery& query) const noexcept {
  run_bundle(*state_, bundle, query, nullptr, blocked, open);
}
void Scene::classify(const SphereBundle& bundle, std::span<uint64_t> blocked, std::span<uint64_t> open,
                     const SceneQuery& query) const noexcept {
  run_bundle(*state_, bundle, query, nullptr, blocked, open);
}

}  // namespace vcd
