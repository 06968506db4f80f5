// Counts a pixel as colours, with the scale drawn below.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "image.h"

namespace vcd::render {

// counts: width × height of them, row by row from the top. Zero is black, `maximum` and all above it the brightest
// colour; the strip below the picture shows the colours, what they stand for, and `caption`.
Image false_colour(const std::vector<double>& counts, uint32_t width, uint32_t height, double maximum,
                   const std::string& caption);

// A round number that all but the highest half per cent of the counts stay below: a scale that a few pixels do not
// spoil.
double scale_for(std::vector<double> counts);

}  // namespace vcd::render
