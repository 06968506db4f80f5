#include "tiles.h"

#include <atomic>
#include <mutex>
#include <thread>

#include <pthread.h>
#include <sched.h>

#include "common/limits.h"

namespace vcd::render {
namespace {

using Clock = std::chrono::steady_clock;

void pin_to(unsigned index) {
  cpu_set_t allowed, one;
  if (sched_getaffinity(0, sizeof allowed, &allowed) != 0) return;
  const unsigned wanted = index % static_cast<unsigned>(std::max(CPU_COUNT(&allowed), 1));
  unsigned seen = 0;
  for (size_t cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (!CPU_ISSET(cpu, &allowed) || seen++ != wanted) continue;
    CPU_ZERO(&one);
    CPU_SET(cpu, &one);
    pthread_setaffinity_np(pthread_self(), sizeof one, &one);
    return;
  }
}

}  // namespace

Result<Rendered> draw_tiles(const World& world, const RenderSettings& settings, uint32_t side,
                            const std::function<std::unique_ptr<TileWorker>()>& make, const RenderHooks& hooks) {
  const unsigned threads = settings.threads ? settings.threads : tools::available_processors();
  std::vector<std::unique_ptr<TileWorker>> workers;
  for (unsigned t = 0; t < threads; ++t) workers.push_back(make());

  Rendered rendered;
  rendered.image = Image(settings.width, settings.height);
  const uint32_t columns = (settings.width + side - 1) / side, rows = (settings.height + side - 1) / side;
  std::atomic<uint32_t> next_tile = 0;
  std::atomic<uint64_t> segments = 0;
  std::atomic<bool> stopped = false;
  std::mutex reporting;
  const auto start = Clock::now();

  const auto work = [&](unsigned index) {
    if (settings.pin) pin_to(index);
    TileWorker& worker = *workers[index];
    for (uint32_t tile; !stopped && (tile = next_tile++) < columns * rows;) {
      if (hooks.stop && hooks.stop()) stopped = true;
      const uint32_t x0 = tile % columns * side, y0 = tile / columns * side;
      const uint64_t before = worker.shadow_segments;
      worker.draw({tile, x0, y0, std::min(x0 + side, settings.width), std::min(y0 + side, settings.height)},
                  rendered.image);
      segments += worker.shadow_segments - before;
      if (const std::unique_lock lock(reporting, std::try_to_lock); lock && hooks.progress)
        hooks.progress({(tile + 1.0) / (columns * rows), segments, seconds_since(start)});
    }
  };
  {
    std::vector<std::jthread> pool;
    for (unsigned t = 0; t < threads; ++t) pool.emplace_back(work, t);
  }
  if (stopped) return Error{ErrorCode::runtime, world.name + ": stopped"};
  rendered.seconds = seconds_since(start);
  for (const auto& worker : workers) {
    rendered.shadow_segments += worker->shadow_segments;
    rendered.object_samples += worker->object_samples;
    rendered.shadow_seconds += worker->shadow_seconds;
  }
  return rendered;
}

}  // namespace vcd::render
