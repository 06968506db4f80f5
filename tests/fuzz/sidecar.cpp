// read_sidecar() on any bytes, at all levels and alignments.
#include <algorithm>
#include <bit>
#include <cstring>
#include <iterator>
#include <memory>
#include <new>
#include <vector>

#include <vcd/format/contents.h>

#include "fuzz/fuzz.h"
#include "fuzz/sidecar_mutator.h"

namespace vcd::fuzz {
namespace {

// The file in memory that ends exactly where it ends, so that AddressSanitizer sees every step too far.
class ExactCopy {
 public:
  ExactCopy(const uint8_t* data, size_t size, size_t shift)
      : shift_(shift), size_(size), memory_(allocate_aligned(shift + size)) {
    if (size > 0) std::memcpy(memory_.data.get() + shift, data, size);
  }
  Bytes bytes() const { return {memory_.data.get() + shift_, size_}; }

 private:
  size_t shift_, size_;
  AlignedBytes memory_;
};

// What a query could read: cells all over the line space, through every array of the tree.
uint32_t look_around(const ObjectContents& object) {
  uint32_t sum = 0;
  for (uint32_t i = 0; i < 64 * kFacePairs; ++i) {
    LineCell line{};
    const uint32_t mixed = i * 2654435761u;
    line.pair = i % kFacePairs, line.s = mixed & 255, line.t = mixed >> 8 & 255, line.u = mixed >> 16 & 255,
    line.v = mixed >> 24;
    sum += static_cast<uint32_t>(class_of(object.tree, line));
    if (object.tree.clearances) sum += within_clearances(object.tree.clearances, line, 0, 1);
  }
  return sum;
}

// What a query could read: everything below a node.
uint32_t look_through(const HierarchyView& hierarchy, uint32_t unit) {
  uint32_t sum = 0;
  for (const uint32_t child : hierarchy.node(unit).child) {
    if (child == kNoChild) break;
    sum += !(child & kLeafChild) ? look_through(hierarchy, child) : with_leaf(hierarchy, child, [](const auto& leaf) {
      uint32_t bits = leaf.present;
      for (const auto& corners : leaf.corner)
        for (const uint8_t c : corners) bits += std::bit_cast<uint32_t>(leaf.vertex[0][c % std::size(leaf.vertex[0])]);
      return bits;
    });
  }
  return sum;
}

// What a query of horizons could read.
uint32_t look_at_places(const ObjectContents& object) {
  uint32_t frames = 0;
  HorizonFrame frame;
  for (uint32_t i = 0; object.horizon && i < object.horizon.header().entries; ++i)
    frames += frame_at(object.hierarchy, object.horizon.entries()[i].place, frame);
  return frames;
}

void use(Bytes file, const SidecarContents& contents, CheckLevel level) {
  volatile uint32_t sum = 0;
  for (const ObjectContents& object : contents.objects) {
    sum = sum + look_around(object) + static_cast<uint32_t>(object.name.size());
    if (object.hierarchy) sum = sum + look_through(object.hierarchy, kRootUnit);
    sum = sum + look_at_places(object);
    for (const std::byte b : object.geometry) sum = sum + static_cast<uint32_t>(b);
  }
  for (const auto& [key, value] : contents.provenance) sum = sum + static_cast<uint32_t>(key.size() + value.size());
  require(std::ranges::is_sorted(contents.provenance), "provenance is sorted");
  if (level < CheckLevel::checksums) return;
  for (const SectionEntry& section : contents.sections)
    require(section_bytes(file, section).size == section.logical_size, "a section of an accepted file can be read");
}

bool read(Bytes file, CheckLevel level) {
  std::vector<Finding> findings;
  const auto contents = read_sidecar(file, level, findings);
  require(contents.has_value() == !has_error(findings), "a file is refused with a finding, and only then");
  for (const Finding& finding : findings) {
    require(finding.offset <= file.size(), "a finding lies in the file");
    require(!describe(finding).empty(), "a finding can be described");
  }
  if (contents) use(file, *contents, level);
  return contents.has_value();
}

}  // namespace
}  // namespace vcd::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace vcd;
  using namespace vcd::fuzz;
  const ExactCopy aligned(data, size, 0), shifted(data, size, 8);
  const bool bounds = read(aligned.bytes(), CheckLevel::bounds),
             checksums = read(aligned.bytes(), CheckLevel::checksums),
             canonical = read(aligned.bytes(), CheckLevel::canonical);
  require(bounds || !checksums, "what the check of checksums accepts, the check of bounds accepts");
  require(checksums || !canonical, "what the canonical check accepts, the check of checksums accepts");
  require(read(shifted.bytes(), CheckLevel::canonical) == canonical, "alignment in memory does not matter");
  if (canonical) planted_bug();
  return 0;
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size, unsigned int seed) {
  return vcd::fuzz::mutate_sidecar(data, size, max_size, seed, false);
}
