// The programs in lab/ are of namespace vcd, and see what is common to all without a prefix.
#pragma once

namespace vcd {
namespace tools {}
using namespace tools;
}  // namespace vcd
