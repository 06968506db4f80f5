// The exit codes of all programs: 0, those of ErrorCode, and one for a batch.
#pragma once

#include <vector>

#include <vcd/format/error.h>

namespace vcd::tools {

inline constexpr int kExitOk = 0;
inline constexpr int kExitBatch = 9;  // some of several inputs failed
inline int exit_code(ErrorCode code) { return static_cast<int>(code); }

// The exit code for a batch: that of the only input, 0 if all are well, else 9.
inline int batch_exit_code(const std::vector<int>& codes) {
  if (codes.size() == 1) return codes[0];
  for (const int code : codes)
    if (code != kExitOk) return kExitBatch;
  return kExitOk;
}

}  // namespace vcd::tools
