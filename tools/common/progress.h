// One line on a terminal that rewrites itself: share done, rate, time left. Silent elsewhere.
#pragma once

#include <string>

#include <vcd/baker/bake.h>

namespace vcd {

class ProgressLine {
 public:
  ProgressLine(std::string label, bool quiet);
  ~ProgressLine();  // wipes the line
  void update(const BakeProgress& progress);

 private:
  std::string label_;
  bool active_;
  double last_shown_ = -1;
};

std::string readable_bytes(uint64_t bytes);     // "3.2 MiB"
std::string readable_count(double count);       // "12.3 million"
std::string readable_seconds(double seconds);   // "1 min 05 s"

}  // namespace vcd
