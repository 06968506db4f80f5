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
      answers_(kMaxBundle),
      instance_answers_(kMaxBundle),
      moved_(kMaxBundle),
      moved_places_(kMaxBundle),
      traced_(kMaxBundle) {}

void SidecarShadows::look_up(const Bundle& bundle, std::span<Visibility> answers) {
  runs_.clear();
  open_.clear();
  places_.clear();
  if (world_.single()) return look_up_one(bundle, answers);
  std::fill_n(answers.begin(), bundle.segments.size(), Visibility::clear);
  if (bundle.segments.empty()) return;
  instances_.visit(Beam(bundle.segments), [&](uint32_t i) { look_up_instance(i, bundle, answers); });
}

void SidecarShadows::look_up_one(const Bundle& bundle, std::span<Visibility> answers) {
  objects_[0].classify(bundle.segments, answers);
  for (size_t i = 0; i < bundle.segments.size(); ++i) {
    if (answers[i] != Visibility::unclassified) continue;
    open_.push_back(bundle.segments[i]);
    places_.push_back(static_cast<uint16_t>(i));
  }
  if (!open_.empty()) runs_.push_back({0, 0, open_.size()});
}

void SidecarShadows::look_up_instance(uint32_t index, const Bundle& bundle, std::span<Visibility> answers) {
  const WorldInstance& instance = world_.instances[index];
  size_t count = 0;
  for (size_t i = 0; i < bundle.segments.size(); ++i) {
    if (answers[i] == Visibility::blocked) continue;
    moved_[count] = to_object(instance.to_object, bundle.segments[i]);
    moved_places_[count++] = static_cast<uint16_t>(i);
  }
  objects_[instance.object].classify(std::span(moved_).first(count), instance_answers_);
  const size_t first = open_.size();
  for (size_t k = 0; k < count; ++k) {
    if (instance_answers_[k] == Visibility::clear) continue;
    answers[moved_places_[k]] = instance_answers_[k];
    if (instance_answers_[k] == Visibility::blocked) continue;
    open_.push_back(moved_[k]);
    places_.push_back(moved_places_[k]);
  }
  if (open_.size() > first) runs_.push_back({instance.object, first, open_.size() - first});
}

void SidecarShadows::cast(const Bundle& bundle, std::span<uint8_t> blocked) {
  look_up(bundle, answers_);
  for (size_t i = 0; i < bundle.segments.size(); ++i) blocked[i] = answers_[i] == Visibility::blocked;
  for (const Run& run : runs_) {
    size_t count = 0;  // an instance that came later may have blocked a segment that this one left open
    for (size_t k = run.first; k < run.first + run.count; ++k) {
      if (blocked[places_[k]]) continue;
      moved_[count] = open_[k];
      moved_places_[count++] = places_[k];
    }
    trace(world_.objects[run.object].tracer.scene(), packets_, std::span(moved_).first(count), traced_);
    for (size_t k = 0; k < count; ++k) blocked[moved_places_[k]] |= traced_[k];
  }
}

}  // namespace vcd
