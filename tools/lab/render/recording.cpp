#include "recording.h"

#include <algorithm>
#include <chrono>
#include <limits>

#include "common/seconds_since.h"

namespace vcd::render {
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
constexpr size_t kOrigins = 3;  // the values of From

std::array<std::vector<size_t>, kOrigins> by_origin(const World& world, const Recording& bundles) {
  std::array<std::vector<size_t>, kOrigins> kinds;
  for (size_t i = 0; i < bundles.size(); ++i) kinds[static_cast<size_t>(from_of(world, bundles[i]))].push_back(i);
  return kinds;
}

}  // namespace

void Recording::append(const Bundle& bundle) {
  places_.push_back(
      {segments_.size(), bundle.segments.size(), bundle.light, bundle.pixel, bundle.surface, bundle.primitive});
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

ShadowWays fastest_ways(const World& world, const RenderSettings& settings, bool looks_up,
                        const MakeCasterWith& make_caster) {
  RenderSettings small = settings;
  small.width = 36, small.height = 24, small.pixel_samples = 1, small.seed = settings.seed ^ kTrialSeed;
  const Recording bundles = record(world, small);
  struct Option {
    bool looks_up;
    EmbreeQuery query;
    std::unique_ptr<ShadowCaster> caster;
    std::vector<double> seconds;
  };
  using Use = LookUpPolicy::Use;
  std::vector<Option> options;
  for (bool look_up : {false, true})
    for (const EmbreeQuery& query : world.ways_to_trace()) {
      if (look_up && !looks_up) continue;
      ShadowWays ways(query);
      ways.policy = look_up ? LookUpPolicy(Use::always, Use::always, Use::always)
                            : LookUpPolicy(Use::never, Use::never, Use::never);
      options.push_back({look_up, query, make_caster(ways), {}});
    }
  ShadowWays best;
  std::vector<uint8_t> blocked(kMaxBundle);
  const auto kinds = by_origin(world, bundles);
  for (size_t kind = 0; kind < kOrigins; ++kind) {
    for (Option& option : options) option.seconds.clear();
    for (int trial = 0; trial < kTrials; ++trial)
      for (Option& option : options) {
        // What was far behind at first does not catch up.
        const auto behind = [&](const Option& other) {
          return !other.seconds.empty() && 2 * other.seconds[0] < option.seconds[0];
        };
        if (trial > 0 && std::any_of(options.begin(), options.end(), behind)) continue;
        const auto start = std::chrono::steady_clock::now();
        for (size_t i : kinds[kind])
          option.caster->cast(bundles[i], std::span(blocked).first(bundles[i].segments.size()));
        option.seconds.push_back(seconds_since(start));
      }
    const auto median = [](Option& option) {
      std::sort(option.seconds.begin(), option.seconds.end());
      return option.seconds[option.seconds.size() / 2];
    };
    double fastest[2] = {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    for (Option& option : options)
      if (const double seconds = median(option); seconds < fastest[option.looks_up]) {
        fastest[option.looks_up] = seconds;
        (option.looks_up ? best.left : best.traced)[kind] = option.query;
      }
    best.policy.fix(static_cast<From>(kind),
                    looks_up && fastest[1] <= LookUpPolicy::kWorthwhile * fastest[0] ? Use::always : Use::never);
  }
  return best;
}

std::string text_of(const ShadowWays& ways) {
  constexpr const char* kNames[kOrigins] = {"outside", "inside", "own"};
  std::string text;
  for (size_t kind = 0; kind < kOrigins; ++kind) {
    const bool looks_up = ways.policy.look_up(static_cast<From>(kind));
    text.append(kind ? "; " : "").append(kNames[kind]).append(": ").append(looks_up ? "look-up, " : "");
    text += name_of((looks_up ? ways.left : ways.traced)[kind]);
  }
  return text;
}

}  // namespace vcd::render
