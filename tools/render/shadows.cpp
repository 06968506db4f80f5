#include "shadows.h"

#include <algorithm>
#include <bit>

namespace vcd {
namespace {

size_t words_of(const Bundle& bundle) { return (bundle.segments.size() + 63) / 64; }

void put(Vec3 v, float (&into)[3]) { into[0] = v.x, into[1] = v.y, into[2] = v.z; }

QuadBundle beam_of(const Bundle& bundle, const Quad& light) {
  QuadBundle quad{};
  std::copy_n(bundle.segments[0].origin, 3, quad.origin);
  put(light.corner, quad.corner), put(light.edge_u, quad.edge_u), put(light.edge_v, quad.edge_v);
  quad.u = bundle.u, quad.v = bundle.v;
  return quad;
}

QuadBundle to_object(const Affine& a, const QuadBundle& world) {
  const auto vec = [](const float(&v)[3]) { return Vec3{v[0], v[1], v[2]}; };
  QuadBundle quad = world;
  put(a.point(vec(world.origin)), quad.origin), put(a.point(vec(world.corner)), quad.corner);
  put(a.vector(vec(world.edge_u)), quad.edge_u), put(a.vector(vec(world.edge_v)), quad.edge_v);
  return quad;
}

std::vector<Box> boxes_of(const World& world) {
  std::vector<Box> boxes;
  for (const WorldInstance& instance : world.instances) boxes.push_back(instance.box);
  return boxes;
}

}  // namespace

SidecarShadows::SidecarShadows(const World& world, std::span<const Object> objects, Packets packets)
    : world_(world),
      objects_(objects.begin(), objects.end()),
      packets_(packets),
      instances_(boxes_of(world)),
      picked_(kMaxBundle),
      places_(kMaxBundle),
      traced_(kMaxBundle) {}

void SidecarShadows::look_up(const Bundle& bundle) {
  const size_t words = words_of(bundle);
  const QuadBundle beam = beam_of(bundle, world_.lights[bundle.light].quad);
  if (world_.single()) return objects_[0].classify(beam, std::span(blocked_).first(words), std::span(open_).first(words));
  std::fill_n(blocked_.begin(), words, uint64_t{0});
  std::fill_n(open_.begin(), words, uint64_t{0});
  instances_.visit(Beam(bundle.segments), [&](uint32_t i) {
    const WorldInstance& instance = world_.instances[i];
    objects_[instance.object].classify(to_object(instance.to_object, beam), std::span(instance_blocked_).first(words),
                                       std::span(instance_open_).first(words));
    for (size_t w = 0; w < words; ++w) blocked_[w] |= instance_blocked_[w], open_[w] |= instance_open_[w];
  });
  for (size_t w = 0; w < words; ++w) open_[w] &= ~blocked_[w];
}

void SidecarShadows::look_up(const Bundle& bundle, std::span<Visibility> answers) {
  look_up(bundle);
  for (size_t i = 0; i < bundle.segments.size(); ++i) {
    const uint64_t blocked = blocked_[i / 64] >> (i % 64) & 1, open = open_[i / 64] >> (i % 64) & 1;
    answers[i] = static_cast<Visibility>(blocked | open << 1);
  }
}

void SidecarShadows::cast(const Bundle& bundle, std::span<uint8_t> blocked) {
  look_up(bundle);
  size_t count = 0;
  for (size_t w = 0; w < words_of(bundle); ++w)
    for (uint64_t left = open_[w]; left; left &= left - 1) {
      const size_t i = 64 * w + static_cast<size_t>(std::countr_zero(left));
      picked_[count] = bundle.segments[i];
      places_[count++] = static_cast<uint16_t>(i);
    }
  for (size_t i = 0; i < bundle.segments.size(); ++i) blocked[i] = blocked_[i / 64] >> (i % 64) & 1;
  trace(world_.shadow_casters(), packets_, std::span(picked_).first(count), traced_);
  for (size_t k = 0; k < count; ++k) blocked[places_[k]] = traced_[k];
}

}  // namespace vcd
