#include "readable.h"

#include <cstdarg>
#include <cstdio>

namespace vcd::tools {
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

std::string readable_percent(double share) { return text("%.1f %%", 100 * share); }

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

}  // namespace vcd::tools
