// A run on a terminal: one line that rewrites itself, and a line or a summary an asset.
#pragma once

#include <memory>

#include "batch.h"
#include "common/program.h"

namespace vcd {

// Text goes to standard output, progress and errors to standard error; progress on a terminal only. verbose: the whole
// summary of each asset, not one line.
std::unique_ptr<BatchListener> make_console(const CommonOptions& options, bool verbose);

}  // namespace vcd
