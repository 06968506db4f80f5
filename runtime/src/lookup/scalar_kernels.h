// The reference: segments one by one, in plain C++. Every other set of kernels equals it bit for bit.
#pragma once

#include "lookup/kernels.h"

namespace vcd {

const Kernels& scalar_kernels();

}  // namespace vcd
