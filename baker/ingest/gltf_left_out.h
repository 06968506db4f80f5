// Which parts of a glTF file do not stand for opaque, rigid triangles.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ingest/gltf_document.h"

namespace vcd::baker {

enum class GltfLeftOutBecause { not_opaque, deforms };

struct GltfLeftOut {
  GltfLeftOutBecause because;
  std::string reason;  // follows "left out: "
};

// For each mesh of the document: does any node give it a skin? The node hierarchy is not walked, so that
// cycles and other defects of it do no harm.
std::vector<bool> find_skinned_meshes(const GltfDocument& document);

// Nothing for a primitive that is opaque and rigid, in each of its material variants.
// Throws GltfFailure (invalid_file) where its materials do not exist or cannot be read.
std::optional<GltfLeftOut> why_left_out(const GltfDocument& document, const tinygltf::Primitive& primitive,
                                        bool skinned);

}  // namespace vcd::baker
