#include "progress.h"

#include <cstdarg>
#include <cstdio>

#include <sys/ioctl.h>
#include <unistd.h>

namespace vcd {
using namespace baker;
namespace {

[[gnu::format(printf, 1, 2)]] std::string text(const char* format, ...) {
  char buffer[160];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof buffer, format, arguments);
  va_end(arguments);
  return buffer;
}

}  // namespace

std::string readable_bytes(uint64_t bytes) {
  if (bytes < 1024) return text("%llu bytes", static_cast<unsigned long long>(bytes));
  const double kib = static_cast<double>(bytes) / 1024;
  return kib < 1024          ? text("%.1f KiB", kib)
         : kib < 1024 * 1024 ? text("%.1f MiB", kib / 1024)
                             : text("%.2f GiB", kib / 1024 / 1024);
}

std::string readable_count(double count) {
  if (count < 1e4) return text("%.0f", count);
  return count < 1e6   ? text("%.1f thousand", count / 1e3)
         : count < 1e9 ? text("%.1f million", count / 1e6)
                       : text("%.2f billion", count / 1e9);
}

std::string readable_seconds(double seconds) {
  if (seconds < 60) return text("%.1f s", seconds);
  const auto whole = static_cast<unsigned long long>(seconds);
  return whole < 3600 ? text("%llu min %02llu s", whole / 60, whole % 60)
                      : text("%llu h %02llu min", whole / 3600, whole / 60 % 60);
}

ProgressLine::ProgressLine(std::string label, bool quiet)
    : label_(std::move(label)), active_(!quiet && isatty(STDERR_FILENO)) {}

ProgressLine::~ProgressLine() { wipe(); }

void ProgressLine::update(const BakeProgress& p) {
  if (!active_) return;
  std::string line = label_ + text(": %.1f %%, ", 100 * p.fraction) +
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

}  // namespace vcd
