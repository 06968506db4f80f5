// One line on a terminal that rewrites itself: share done, rate, time left. Silent elsewhere.
#pragma once

#include <chrono>
#include <string>

#include <vcd/baker/bake.h>

#include "readable.h"

namespace vcd::tools {

class ProgressLine {
 public:
  ProgressLine(std::string label, bool quiet);
  ~ProgressLine();  // wipes the line
  void update(const baker::BakeProgress& progress);
  void show(const std::string& text);  // ten times a second at most, cut to the terminal's width
  void wipe();                         // so that something else may be printed

 private:
  using Clock = std::chrono::steady_clock;
  std::string label_;
  bool active_;
  bool visible_ = false;
  Clock::time_point next_ = Clock::now();
};

}  // namespace vcd::tools
