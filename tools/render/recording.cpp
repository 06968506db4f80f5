#include "recording.h"

#include <algorithm>
#include <chrono>

namespace vcd {
namespace {

class Recorder : public ShadowCaster {
 public:
  explicit Recorder(Recording& recording) : recording_(recording) {}
  void cast(const Bundle& bundle, std::span<uint8_t> blocked) override {
    recording_.append(bundle);
    std::fill(blocked.begin(), blocked.end(), uint8_t{0});
  }

 private:
  Recording& recording_;
};

constexpr uint64_t kTrialSeed = 0x7419;
constexpr int kTrials = 5;

}  // namespace

void Recording::append(const Bundle& bundle) {
  places_.push_back({segments_.size(), bundle.segments.size(), bundle.light, bundle.pixel, bundle.surface});
  segments_.insert(segments_.end(), bundle.segments.begin(), bundle.segments.end());
  u_.insert(u_.end(), bundle.u.begin(), bundle.u.end());
  v_.insert(v_.end(), bundle.v.begin(), bundle.v.end());
}

Recording record(const World& world, RenderSettings settings) {
  Recording recording;
  settings.threads = 1;
  (void)render(world, settings, [&] { return std::make_unique<Recorder>(recording); });
  return recording;
}

Packets fastest_packets(const World& world, const RenderSettings& settings, const std::vector<Packets>& ways,
                        const std::function<std::unique_ptr<ShadowCaster>(Packets)>& make_caster) {
  RenderSettings small = settings;
  small.width = 36, small.height = 24, small.pixel_samples = 1, small.seed = settings.seed ^ kTrialSeed;
  const Recording bundles = record(world, small);
  std::vector<std::unique_ptr<ShadowCaster>> casters;
  for (const Packets& way : ways) casters.push_back(make_caster(way));
  std::vector<std::vector<double>> seconds(ways.size());
  std::vector<uint8_t> blocked(kMaxBundle);
  for (int trial = 0; trial < kTrials; ++trial)
    for (size_t w = 0; w < ways.size(); ++w) {
      const auto start = std::chrono::steady_clock::now();
      for (size_t i = 0; i < bundles.size(); ++i) casters[w]->cast(bundles[i], std::span(blocked).first(bundles[i].segments.size()));
      seconds[w].push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
  size_t best = 0;
  for (std::vector<double>& s : seconds) std::sort(s.begin(), s.end());
  for (size_t w = 1; w < ways.size(); ++w)
    if (seconds[w][kTrials / 2] < seconds[best][kTrials / 2]) best = w;
  return ways[best];
}

}  // namespace vcd
