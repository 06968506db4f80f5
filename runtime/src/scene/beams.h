// Many segments as one beam through the hierarchy.
#pragma once

#include <cstddef>
#include <optional>

#include "beam/beam.h"
#include "lookup/segment_columns.h"
#include "lookup/to_grid.h"
#include "scene/boxes.h"

namespace vcd {

// The segments of a bundle's chunk, which is measured and finite.
SceneBeam beam_of(const BeamFrame& frame, const BundleChunk& chunk);

// Whether what is computed of the chunk stays finite: twice its size does.
bool is_finite(const BeamFrame& frame, const BundleChunk& chunk);

// Whether rounding of the segments' directions stays within the guard band of an instance's grid.
bool near_enough(const ToGrid& grid, const BeamFrame& frame, const BundleChunk& chunk);

// Segments first … first + count - 1; nothing if they have too little in common to be one beam, or begin before t = 0.
std::optional<SceneBeam> beam_of(const SegmentColumns<kChunk>& columns, size_t first, size_t count);

}  // namespace vcd
