#include "recorded.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <stdexcept>

namespace vcd::render {

using namespace baker;
namespace {

size_t words_of(const Bundle& bundle) { return (bundle.segments.size() + 63) / 64; }

// A byte a bit. Eight at a time: a multiplication puts eight copies side by side, and one bit of each is kept.
void unpack(std::span<const uint64_t> bits, std::span<uint8_t> bytes) {
  for (size_t i = 0; i < bytes.size(); i += 8) {
    const uint64_t eight = bits[i / 64] >> (i % 64) & 0xFF;
    const uint64_t apart = eight * 0x0101010101010101u & 0x8040201008040201u;
    const uint64_t ones = (apart + 0x7F7F7F7F7F7F7F7Fu) >> 7 & 0x0101010101010101u;
    std::memcpy(bytes.data() + i, &ones, std::min<size_t>(8, bytes.size() - i));
  }
}

void put(Vec3 v, float (&into)[3]) { into[0] = v.x, into[1] = v.y, into[2] = v.z; }

}  // namespace

QuadBundle quad_of(const World& world, const Bundle& bundle) {
  const Quad& light = world.lights[bundle.light].quad;
  QuadBundle quad{};
  std::copy_n(bundle.segments[0].origin, 3, quad.origin);
  put(light.corner, quad.corner), put(light.edge_u, quad.edge_u), put(light.edge_v, quad.edge_v);
  quad.u = bundle.u, quad.v = bundle.v;
  return quad;
}

namespace {

Transform transform_of(const Affine& a) {
  const auto row = [&](float Vec3::*axis, int i, Transform& t) {
    for (int j = 0; j < 3; ++j) t.rows[i][j] = a.column[j].*axis;
    t.rows[i][3] = a.offset.*axis;
  };
  Transform t;
  row(&Vec3::x, 0, t), row(&Vec3::y, 1, t), row(&Vec3::z, 2, t);
  return t;
}

}  // namespace

// Of what was there when the world was built: it cannot fail but for want of memory.
Scene scene_of(const World& world, std::span<const Object> objects) {
  std::vector<SceneInstance> instances;
  for (const WorldInstance& instance : world.instances)
    instances.push_back(SceneInstance::of(objects[instance.object], transform_of(instance.to_world)));
  auto scene = Scene::build(instances);
  if (!scene) throw std::runtime_error(scene.error().message);
  return std::move(*scene);
}

Result<Recorder> recorder_of(const World& world, size_t most) {
  std::vector<RecordedInstance> instances;
  for (const WorldInstance& instance : world.instances) {
    const PreparedMesh& mesh = world.objects[instance.object].mesh;
    // A single object is asked in its own frame.
    const Transform to_world = world.single() ? transform_of(Affine{}) : transform_of(instance.to_world);
    instances.push_back({mesh.geometry_hash, {std::nullopt, {}, {}, to_world}});
    std::ranges::copy(mesh.box_min, instances.back().place.box_min);
    std::ranges::copy(mesh.box_max, instances.back().place.box_max);
  }
  return Recorder::build(instances, most);
}

// A bundle has one origin: a query's origins are one.
SceneQuery query_of(const Bundle& bundle, bool by_horizons) {
  SceneQuery query;
  if (bundle.surface == kGroundSurface) return query;
  query.origins = std::span(&bundle.surface, 1);
  if (by_horizons) query.primitives = std::span(&bundle.primitive, 1);
  return query;
}

From from_of(const World& world, const Bundle& bundle) { return from_of(world, bundle.surface, bundle.segments[0]); }

From from_of(const World& world, uint32_t surface, const Segment& segment) {
  if (surface != kGroundSurface) return From::self;
  if (!world.single()) return From::outside;
  const PreparedMesh& mesh = world.objects[0].mesh;
  bool inside = true;
  for (size_t a = 0; a < 3; ++a) {
    const float o = segment.origin[a];
    inside &= o > mesh.box_min[a] && o < mesh.box_max[a];
  }
  return inside ? From::inside : From::outside;
}

SidecarShadows::SidecarShadows(const World& world, std::span<const Object> objects, const ShadowWays& ways)
    : world_(world), ways_(ways), picked_(kMaxBundle), places_(kMaxBundle), traced_(kMaxBundle) {
  if (world.single()) {
    object_ = objects[0];
    return;
  }
  scene_.emplace(scene_of(world, objects));
  for (const WorldInstance& instance : world.instances)
    hierarchies_.push_back(world.objects[instance.object].tracer.scene());
}

void SidecarShadows::look_up(const Bundle& bundle) {
  const auto blocked = std::span(blocked_).first(words_of(bundle)), open = std::span(open_).first(words_of(bundle));
  const QuadBundle beam = quad_of(world_, bundle);
  if (object_) object_->classify(beam, blocked, open);
  else scene_->classify(beam, blocked, open, query_of(bundle));
}

void SidecarShadows::look_up(const Bundle& bundle, std::span<Visibility> answers) {
  look_up(bundle);
  for (size_t i = 0; i < bundle.segments.size(); ++i) {
    const uint64_t blocked = blocked_[i / 64] >> (i % 64) & 1, open = open_[i / 64] >> (i % 64) & 1;
    answers[i] = static_cast<Visibility>(blocked | open << 1);
  }
}

void SidecarShadows::cast(const Bundle& bundle, std::span<uint8_t> blocked) {
  const From from = from_of(world_, bundle);
  const size_t kind = static_cast<size_t>(from);
  if (!ways_.policy.look_up(from))
    return occluded(world_.shadow_casters(), ways_.traced[kind], bundle.segments, blocked.data());
  if (object_) {
    look_up(bundle);
  } else {
    const EmbreeInstances fallback{hierarchies_, ways_.left[kind]};
    scene_->occluded(quad_of(world_, bundle), std::span(blocked_).first(words_of(bundle)), fallback, query_of(bundle));
  }
  unpack(blocked_, blocked);
  if (object_) trace_open(bundle, ways_.left[kind], blocked);
}

void SidecarShadows::trace_open(const Bundle& bundle, EmbreeQuery query, std::span<uint8_t> blocked) {
  size_t count = 0;
  for (size_t w = 0; w < words_of(bundle); ++w)
    for (uint64_t left = open_[w]; left; left &= left - 1) {
      const size_t i = 64 * w + static_cast<size_t>(std::countr_zero(left));
      picked_[count] = bundle.segments[i];
      places_[count++] = static_cast<uint16_t>(i);
    }
  occluded(world_.shadow_casters(), query, std::span(picked_).first(count), traced_.data());
  for (size_t k = 0; k < count; ++k) blocked[places_[k]] = traced_[k];
}

bool have_hierarchies(std::span<const Object> objects) { return std::ranges::all_of(objects, &Object::has_hierarchy); }
bool some_has_horizons(std::span<const Object> objects) { return std::ranges::any_of(objects, &Object::has_horizons); }

HierarchyShadows::HierarchyShadows(const World& world, std::span<const Object> objects, bool by_horizons)
    : world_(world), by_horizons_(by_horizons) {
  if (world.single()) object_ = objects[0];
  else scene_.emplace(scene_of(world, objects));
}

void HierarchyShadows::cast(const Bundle& bundle, std::span<uint8_t> blocked) {
  std::array<uint64_t, kMaxBundle / 64> bits;
  const auto words = std::span(bits).first(words_of(bundle));
  const From from = from_of(world_, bundle);
  if (object_ && by_horizons_ && from == From::self)
    object_->occluded_self(quad_of(world_, bundle), bundle.primitive, words);
  else if (object_) object_->occluded(quad_of(world_, bundle), words, from);
  else scene_->occluded(quad_of(world_, bundle), words, query_of(bundle, by_horizons_));
  unpack(words, blocked);
}

}  // namespace vcd::render
