#include "recorded.h"

#include <algorithm>

namespace vcd::render {
namespace {

// Direct light alone: what the camera sees does not depend on the answers.
class NoShadows : public ShadowCaster {
 public:
  void cast(const Bundle&, std::span<uint8_t> blocked) override { std::ranges::fill(blocked, uint8_t{0}); }
};

}  // namespace

Result<Demand> demand_of_picture(const World& world, RenderSettings settings, size_t most, const RenderHooks& hooks) {
  auto recorder = recorder_of(world, most);
  if (!recorder) return recorder.error();
  settings.threads = 1;
  const auto rendered = render(
      world, settings,
      [&] { return std::make_unique<RecordedShadows>(std::make_unique<NoShadows>(), recorder->thread()); }, hooks);
  if (!rendered) return rendered.error();
  return recorder->demand();
}

}  // namespace vcd::render
