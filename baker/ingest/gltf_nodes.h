// Where the nodes of a glTF file put its meshes.
#pragma once

#include <vcd/baker/ingest.h>

#include <array>

#include "ingest/gltf_document.h"

namespace vcd::baker {

// Appends to ingested.placements one placement for each node of the default scene that has one of
// ingested.meshes, in the order of the nodes, and to ingested.notes what is left out: instances of
// EXT_mesh_gpu_instancing, and transforms that are not invertible.
//
// The default scene is `scene`, else scene 0; in a file without scenes, all nodes. All nodes are checked, also those
// outside the scene. What other loaders take is taken with a note: a node of two parents, a root that is a child too,
// both a matrix and parts of one, a last row of a matrix that is not 0 0 0 1, a rotation without a direction, a cycle
// (which is left out). Throws GltfFailure (invalid_file), which names the node: indices out of range, transforms that
// are not so many numbers. Time and memory are linear in the nodes, however deep they are nested.
// lights: whether to append the scene's lights to ingested.lights, too (gltf_lights.h).
void read_placements(const GltfDocument& document, bool lights, Ingested& ingested);

// Why single precision cannot undo a row-major 3 x 4 transform ("its scale is zero"); nullptr if it can.
const char* why_not_invertible(const std::array<double, 12>& transform);

}  // namespace vcd::baker
