// A run on a terminal: one line that rewrites itself, and a line or a summary an asset.
#pragma once

#include <memory>

#include <vcd/library/batch.h>
#include "common/program.h"

namespace vcd::tools {

// Text goes to standard output, progress and errors to standard error; progress on a terminal only. verbose: the whole
// summary of each asset, not one line.
std::unique_ptr<library::BatchListener> make_console(const CommonOptions& options, bool verbose);

}  // namespace vcd::tools
