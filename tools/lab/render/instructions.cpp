#include "instructions.h"

#include <hwy/targets.h>

namespace vcd::render {
namespace {

std::string config;

}  // namespace

std::vector<std::string> older_instructions() { return {"avx2", "sse4"}; }

void limit_instructions(const std::string& instructions) {
  if (instructions.empty()) return;
  config = "isa=" + std::string(instructions == "sse4" ? "sse4.2" : instructions);
  // A target with more instructions has a lower bit.
  const int64_t oldest = instructions == "sse4" ? HWY_SSE4 : HWY_AVX2;
  hwy::DisableTargets(oldest - 1);
}

const char* embree_config() { return config.empty() ? nullptr : config.c_str(); }

}  // namespace vcd::render
