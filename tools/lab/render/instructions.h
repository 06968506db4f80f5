// Which instructions may be measured: Embree and the runtime can both be held to those of older processors.
#pragma once

#include <string>
#include <vector>

namespace vcd::render {

// "avx2" and "sse4".
std::vector<std::string> older_instructions();

// From here on Embree's devices and the runtime's kernels use no later instructions than these, in this process. Call
// it first of all. instructions: one of older_instructions(); empty: all that there are.
void limit_instructions(const std::string& instructions);

// For rtcNewDevice().
const char* embree_config();

}  // namespace vcd::render
