#include "progress.h"

#include <cstdio>

#include <sys/ioctl.h>
#include <unistd.h>

namespace vcd::tools {

using namespace baker;

ProgressLine::ProgressLine(std::string label, bool quiet)
    : label_(std::move(label)), active_(!quiet && isatty(STDERR_FILENO)) {}

ProgressLine::~ProgressLine() { wipe(); }

void ProgressLine::update(const BakeProgress& p) {
  if (!active_) return;
  std::string line = label_ + ": " + readable_percent(p.fraction) + ", " +
                     readable_count(p.seconds > 0 ? static_cast<double>(p.rays) / p.seconds : 0) + " rays/s";
  if (p.fraction > 0.005) line += ", " + readable_seconds(p.seconds / p.fraction - p.seconds) + " left";
  show(line);
}

void ProgressLine::show(const std::string& line) {
  if (!active_ || Clock::now() < next_) return;
  next_ = Clock::now() + std::chrono::milliseconds(100);
  winsize size{};
  const size_t width = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1 ? size.ws_col - 1u : 200u;
  std::fprintf(stderr, "\r%s\033[K", line.substr(0, width).c_str());
  std::fflush(stderr);
  visible_ = true;
}

void ProgressLine::wipe() {
  if (visible_) std::fprintf(stderr, "\r\033[K");
  visible_ = false;
}

}  // namespace vcd::tools
