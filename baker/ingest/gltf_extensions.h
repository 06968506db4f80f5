// Which glTF extensions a file may require.
#pragma once

#include <string>
#include <vector>

namespace vcd::baker {

// A file lists in extensionsRequired what it cannot be read without. What is decoded here is accepted, and
// what cannot change the triangles of a mesh; any other is refused, since its geometry would be guessed.
// Throws GltfFailure (unsupported, naming the extension).
void check_required_extensions(const std::vector<std::string>& names);

}  // namespace vcd::baker
