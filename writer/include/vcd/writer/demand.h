// Segments that were asked → a demand, and its file. Renderers that only answer do not need this library.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include <vcd/format/demand.h>

namespace vcd {

// A sample in any order as a demand holds it: sorted, and of equal segments one with the sum of their weights.
// Segments of a weight that no demand may hold, or that are not usable_in_demand(), are left out.
std::vector<AskedSegment> in_order(std::vector<AskedSegment> segments);

// What all of them ask, each as often as it was recorded. The order does not matter, as long as weights are counts
// below 2^53: their sums are exact.
Demand merge(std::span<const Demand> demands);

uint64_t segment_count(const Demand& demand);

// At most `most` segments that stand for all: a priority sample (Duffield, Lund and Thorup 2007), so that the weight of
// any part of the demand is what it was, in the mean. The same demand and number give the same sample. Objects of which
// no segment is left are no longer in it.
Demand thin(Demand demand, uint64_t most);

// Writes the file beside `path` (AtomicFile), reads it back, and puts it in the place of `path`. Returns its size. The
// same demand always gives the same bytes. Errors: usage (it asks nothing, or more than a file may hold); io; runtime
// (out of memory).
Result<uint64_t> write_demand(const std::filesystem::path& path, const Demand& demand);

}  // namespace vcd
