// Many segments as one beam through the hierarchy.
#pragma once

#include <cstddef>
#include <optional>

#include "beam/beam.h"
#include "lookup/segment_columns.h"
#include "lookup/to_grid.h"
#include "scene/boxes.h"

namespace vcd {

// Whether a bundle's chunk, which is measured, is within the limits of <trusted.h>.
bool is_trusted(const BeamFrame& frame, const BundleChunk& chunk);

// Its segments.
SceneBeam beam_of(const BeamFrame& frame, const BundleChunk& chunk);

// Whether rounding of the segments' directions stays within the guard band of an instance's grid.
bool near_enough(const ToGrid& grid, const BeamFrame& frame, const BundleChunk& chunk);

// Segments first … first + count - 1, which are trusted; nothing if they have too little in common to be one beam, or
// begin before t = 0.
std::optional<SceneBeam> beam_of(const SegmentColumns<kChunk>& columns, size_t first, size_t count);

}  // namespace vcd
