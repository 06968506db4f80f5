// How messages name a mesh.
#pragma once

#include <string>

#include <vcd/baker/prepare.h>

namespace vcd::baker {

inline std::string place_of(const PreparedMesh& mesh) {
  return "mesh " + std::to_string(mesh.source_index) + " \"" + mesh.name + "\"";
}

}  // namespace vcd::baker
