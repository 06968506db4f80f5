#include "shadows.h"

namespace vcd {
namespace {

Segment to_object(const Affine& a, const Segment& s) {
  const Vec3 p = a.point({s.origin[0], s.origin[1], s.origin[2]});
  const Vec3 d = a.vector({s.direction[0], s.direction[1], s.direction[2]});
  return {{p.x, p.y, p.z}, s.t_min, {d.x, d.y, d.z}, s.t_max};
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
      answers_(kMaxBundle),
      picked_answers_(kMaxBundle),
      traced_(kMaxBundle) {}

void SidecarShadows::look_up(const Bundle& bundle, std::span<Visibility> answers) {
  if (world_.single()) return objects_[0].classify(bundle.segments, answers);
  std::fill_n(answers.begin(), bundle.segments.size(), Visibility::clear);
  instances_.visit(Beam(bundle.segments), [&](uint32_t i) { look_up_instance(i, bundle, answers); });
}

void SidecarShadows::look_up_instance(uint32_t index, const Bundle& bundle, std::span<Visibility> answers) {
  const WorldInstance& instance = world_.instances[index];
  size_t count = 0;
  for (size_t i = 0; i < bundle.segments.size(); ++i) {
    if (answers[i] == Visibility::blocked) continue;
    picked_[count] = to_object(instance.to_object, bundle.segments[i]);
    places_[count++] = static_cast<uint16_t>(i);
  }
  objects_[instance.object].classify(std::span(picked_).first(count), picked_answers_);
  for (size_t k = 0; k < count; ++k)
    if (picked_answers_[k] != Visibility::clear) answers[places_[k]] = picked_answers_[k];
}

void SidecarShadows::cast(const Bundle& bundle, std::span<uint8_t> blocked) {
  look_up(bundle, answers_);
  size_t count = 0;
  for (size_t i = 0; i < bundle.segments.size(); ++i) {
    blocked[i] = answers_[i] == Visibility::blocked;
    if (answers_[i] != Visibility::unclassified) continue;
    picked_[count] = bundle.segments[i];
    places_[count++] = static_cast<uint16_t>(i);
  }
  trace(world_.shadow_casters(), packets_, std::span(picked_).first(count), traced_);
  for (size_t k = 0; k < count; ++k) blocked[places_[k]] = traced_[k];
}

}  // namespace vcd
