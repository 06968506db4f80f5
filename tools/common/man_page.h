// A program's man page, section 1, from its options: what --help says, as troff. The same bytes on every day and
// machine.
#pragma once

#include <string>

#include "option_table.h"

namespace vcd {

std::string man_page(const CommandEntry& program);

}  // namespace vcd
