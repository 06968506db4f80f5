#include "demand/divided_bytes.h"

#include <algorithm>
#include <span>
#include <unordered_set>
#include <vector>

#include <vcd/format/checksum.h>

namespace vcd::baker {
namespace {

// Blocks are told apart by a hash of their content. Were two of them mistaken for one, the tree would be larger than
// said, by a block.
class Blocks {
 public:
  explicit Blocks(const DividedCells& divided) : divided_(divided), of_step_(divided.steps().size()) {
    divided.for_top([&](const Cell& cell) { add(cell, 0); });
  }

  uint64_t bytes() const {
    uint64_t sum = tree_shape(divided_.steps().back().to).top_bytes();
    for (const auto& blocks : of_step_) sum += (kUniformBlocks + 1 + blocks.size()) * kBlockBytes;
    return sum;
  }

 private:
  // What stands for the cell where it is divided by the step: the class of all below it, or the hash of its block.
  uint64_t add(const Cell& cell, size_t step) {
    const uint8_t* classes = divided_.classes_below(cell);
    if (!classes) return kUnclassified;
    const Step& below = divided_.steps()[step];
    std::vector<uint64_t> content(below.children());
    for (uint32_t i = 0; i < content.size(); ++i) {
      const uint8_t value = classes[i];
      if (value < kDeeper) content[i] = value;
      else if (step + 1 < of_step_.size() && divided_.classes_below(below.cell(cell, i)))
        content[i] = add(below.cell(cell, i), step + 1);
      else content[i] = value == kDeeper ? kUnclassified : value - uint32_t{DividedCells::kAsked};
    }
    if (content[0] < kDeeper && std::ranges::count(content, content[0]) == std::ssize(content)) return content[0];
    const uint64_t hash = checksum(std::as_bytes(std::span(content)));
    of_step_[step].insert(hash);
    return hash;
  }

  const DividedCells& divided_;
  std::vector<std::unordered_set<uint64_t>> of_step_;
};

}  // namespace

uint64_t bytes_of(const DividedCells& divided) { return Blocks(divided).bytes(); }

}  // namespace vcd::baker
