// A picture drawn tile by tile, by several threads.
#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include "common/seconds_since.h"
#include "renderer.h"

namespace vcd::render {

struct Tile {
  uint32_t index;           // row by row
  uint32_t x0, y0, x1, y1;  // pixels from x0, y0 up to but without x1, y1
};

// One thread's share of the work.
class TileWorker {
 public:
  virtual ~TileWorker() = default;
  virtual void draw(const Tile& tile, Image& image) = 0;

  // What it did so far, as Rendered has it.
  uint64_t shadow_segments = 0, object_samples = 0;
  double shadow_seconds = 0;
};

// side  of a tile, in pixels
// make  a worker; called for all threads before they start
// Errors: runtime (stopped).
Result<Rendered> draw_tiles(const World& world, const RenderSettings& settings, uint32_t side,
                            const std::function<std::unique_ptr<TileWorker>()>& make, const RenderHooks& hooks);

// Seconds that pass while it lives are added.
class Stopwatch {
 public:
  explicit Stopwatch(double& seconds) : seconds_(seconds) {}
  ~Stopwatch() { seconds_ += seconds_since(start_); }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& seconds_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace vcd::render
