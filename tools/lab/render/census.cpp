#include "census.h"

#include <algorithm>
#include <optional>

#include <vcd/format/line_cell.h>

namespace vcd::render {

using namespace baker;

const char* segment_kind_name(SegmentKind kind) {
  constexpr const char* kNames[kSegmentKinds] = {"missing", "piercing",         "own",
                                                 "inside",  "instanced-ground", "instanced-own"};
  return kNames[static_cast<size_t>(kind)];
}

SegmentKind segment_kind(const World& world, uint32_t surface, const Segment& s) {
  const bool from_ground = surface == kGroundSurface;
  if (!world.single()) return from_ground ? SegmentKind::instanced_ground : SegmentKind::instanced_own;
  if (!from_ground) return SegmentKind::own;
  const PreparedMesh& mesh = world.objects[0].mesh;
  const LineCell line = locate(make_grid_frame(mesh.box_min.data(), mesh.box_max.data()), s);
  if (!line.hits || s.t_min >= line.t_exit || s.t_max <= line.t_entry) return SegmentKind::missing;
  return s.t_min <= line.t_entry && s.t_max >= line.t_exit ? SegmentKind::piercing : SegmentKind::inside;
}

void KindCounts::add(const KindCounts& o) {
  segments += o.segments, wrong += o.wrong, wrong_answered += o.wrong_answered;
  for (int i = 0; i < 2; ++i) answered[i] += o.answered[i];
}

KindCounts CensusPass::total() const {
  KindCounts sum;
  for (const KindCounts& k : kinds) sum.add(k);
  return sum;
}

class Census::Caster : public ShadowCaster {
 public:
  Caster(Census& census, CensusPass& pass) : census_(census), pass_(pass), answers_(kMaxBundle), truth_(kMaxBundle) {
    if (census.whole_) whole_ = census.whole_();
    else if (!census.objects_.empty()) sidecars_.emplace(census.world_, census.objects_, census.truth_);
  }

  void cast(const Bundle& bundle, std::span<uint8_t> blocked) override {
    if (whole_) cast_whole(bundle, blocked);
    else if (sidecars_) cast_with_sidecars(bundle, blocked);
    else cast_with_bvh(bundle, blocked);
  }

 private:
  void cast_with_bvh(const Bundle& bundle, std::span<uint8_t> blocked) {
    trace(bundle, blocked);
    std::copy_n(blocked.begin(), bundle.segments.size(), truth_.begin());
    if (census_.learning_) census_.learning_->learn(bundle.segments, blocked, truth_);
    uint64_t tests = 0;
    for (size_t i = 0; i < bundle.segments.size(); ++i) {
      KindCounts& kind = kind_of(bundle, bundle.segments[i]);
      ++kind.segments;
      kind.wrong += blocked[i] != truth_[i];
      tests += census_.counter_->count(bundle.segments[i]).tests;
    }
    add_to_pixel(bundle, tests, bundle.segments.size());
  }

  void cast_with_sidecars(const Bundle& bundle, std::span<uint8_t> blocked) {
    sidecars_->look_up(bundle, answers_);
    sidecars_->cast(bundle, blocked);
    const auto [tests, open] = count(bundle, blocked);
    add_to_pixel(bundle, tests, open);
  }

  void cast_whole(const Bundle& bundle, std::span<uint8_t> blocked) {
    whole_->cast(bundle, blocked);
    for (size_t i = 0; i < bundle.segments.size(); ++i)
      answers_[i] = blocked[i] ? Visibility::blocked : Visibility::clear;
    count(bundle, blocked);
  }

  struct Traced {
    uint64_t tests = 0, open = 0;
  };
  // answers_ and blocked, against the truth.
  Traced count(const Bundle& bundle, std::span<const uint8_t> blocked) {
    trace(bundle, truth_);
    if (census_.judge_) census_.judge_->correct(bundle.segments, truth_);
    Traced traced;
    for (size_t i = 0; i < bundle.segments.size(); ++i) {
      KindCounts& kind = kind_of(bundle, bundle.segments[i]);
      const bool answered = answers_[i] != Visibility::unclassified, wrong = blocked[i] != truth_[i];
      ++kind.segments;
      if (answered) ++kind.answered[answers_[i] == Visibility::blocked];
      traced.open += !answered;
      if (!answered) traced.tests += census_.counter_->count(bundle.segments[i]).tests;
      kind.wrong += wrong;
      kind.wrong_answered += wrong && answered;
    }
    return traced;
  }

  void trace(const Bundle& bundle, std::span<uint8_t> blocked) const {
    occluded(census_.world_.shadow_casters(), census_.truth_, bundle.segments, blocked.data());
  }
  KindCounts& kind_of(const Bundle& bundle, const Segment& segment) {
    return pass_.kinds[static_cast<size_t>(segment_kind(census_.world_, bundle.surface, segment))];
  }
  void add_to_pixel(const Bundle& bundle, uint64_t tests, uint64_t open) {  // a pixel is one thread's
    pass_.tests += tests;
    census_.pass_.pixel_tests[bundle.pixel] += static_cast<double>(tests);
    census_.pass_.pixel_open[bundle.pixel] += static_cast<double>(open);
  }

  Census& census_;
  CensusPass& pass_;
  std::unique_ptr<ShadowCaster> whole_;
  std::optional<SidecarShadows> sidecars_;
  std::vector<Visibility> answers_;
  std::vector<uint8_t> truth_;
};

Census::Census(const World& world, std::vector<Object> objects, const TestCounter& counter, EmbreeQuery truth,
               size_t pixels, Judge* judge)
    : world_(world), objects_(std::move(objects)), counter_(&counter), truth_(truth), judge_(judge) {
  if (objects_.empty()) learning_ = judge;
  pass_.pixel_tests.resize(pixels);
  pass_.pixel_open.resize(pixels);
}

Census::Census(const World& world, MakeCaster whole, EmbreeQuery truth, size_t pixels, const Judge* judge)
    : world_(world), whole_(std::move(whole)), truth_(truth), judge_(judge) {
  pass_.pixel_tests.resize(pixels);
  pass_.pixel_open.resize(pixels);
}

std::unique_ptr<ShadowCaster> Census::caster() {
  passes_.push_back(std::make_unique<CensusPass>());
  return std::make_unique<Caster>(*this, *passes_.back());
}

CensusPass Census::take() {
  for (const auto& pass : passes_) {
    pass_.tests += pass->tests;
    for (size_t k = 0; k < kSegmentKinds; ++k) pass_.kinds[k].add(pass->kinds[k]);
  }
  return std::move(pass_);
}

}  // namespace vcd::render
