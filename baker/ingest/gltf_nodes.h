// Where the nodes of a glTF file put its meshes.
#pragma once

#include <vcd/baker/ingest.h>

#include <array>

#include "ingest/gltf_document.h"

namespace vcd {

// Appends to ingested.placements one placement for each node of the default scene that has one of
// ingested.meshes, in the order of the nodes, and to ingested.notes what is left out: instances of
// EXT_mesh_gpu_instancing, and transforms that are not invertible.
//
// The default scene is `scene`, else scene 0; in a file without scenes, all nodes. The hierarchy is checked
// for all nodes, transforms and meshes for those of the scene.
// Throws GltfFailure (invalid_file), which names the node: indices out of range, cycles, two parents,
// malformed transforms. Time and memory are linear in the nodes, however deep they are nested.
void read_placements(const GltfDocument& document, Ingested& ingested);

// Why single precision cannot undo a row-major 3 x 4 transform ("its scale is zero"); nullptr if it can.
const char* why_not_invertible(const std::array<float, 12>& transform);

}  // namespace vcd
