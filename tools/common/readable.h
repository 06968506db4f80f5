// Numbers for people.
#pragma once

#include <cstdint>
#include <string>

namespace vcd::tools {

std::string readable_percent(double share);    // "12.5 %"
std::string readable_bytes(uint64_t bytes);    // "3.2 MiB"
std::string readable_count(double count);      // "12.3 million"
std::string readable_seconds(double seconds);  // "1 min 05 s"

}  // namespace vcd::tools
