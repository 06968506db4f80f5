#pragma once

#include <vcd/baker/prepare.h>

namespace vcd::baker {

// Fills in the padded box from the positions. False if no usable box exists in 32-bit floats.
bool pad_box(PreparedMesh& mesh);

}  // namespace vcd::baker
