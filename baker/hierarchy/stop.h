#pragma once

#include <atomic>
#include <functional>

namespace vcd::baker {

// Whether a computation on many threads is to end early. Once true, it stays so.
class Stop {
 public:
  explicit Stop(const std::function<bool()>& ask) : ask_(ask) {}

  // Asks. From many threads at once.
  bool now() {
    if (ask_ && !stopped_ && ask_()) stopped_ = true;
    return stopped_;
  }
  bool stopped() const { return stopped_; }

 private:
  const std::function<bool()>& ask_;
  std::atomic<bool> stopped_ = false;
};

}  // namespace vcd::baker
