#include "lookup/range_class.h"

#include <algorithm>
#include <cstring>

namespace vcd {
namespace {

class Reader {
 public:
  explicit Reader(const TreeView& tree)
      : tree_(tree),
        shape_(tree.shape),
        statistics_count_(tree.answers(Place::pierces, CellClass::statistically_blocked) == Visibility::blocked) {}

  Visibility classify(const CellRange& range) {
    const bool agree = each_child(
        range, shape_.levels - shape_.top_levels,
        [&](uint32_t at, const CellRange& part) {
          return visit_block(0, tree_.top[range.pair << (4 * shape_.top_levels) | at], part);
        },
        shape_.top_levels);
    if (!agree || seen_unclassified_) return Visibility::unclassified;
    return seen_clear_ ? Visibility::clear : Visibility::blocked;
  }

 private:
  // visit(row-major index, its part of the range) for each child that the range reaches, until one returns false. A
  // child is 2^below cells wide, and there are 2^bits in a row.
  template <class Visit>
  bool each_child(const CellRange& range, uint32_t below, const Visit& visit, uint32_t bits) {
    uint32_t first[4], last[4];
    uint32_t count = 1;
    for (int d = 0; d < 4; ++d) {
      first[d] = range.low[d] >> below, last[d] = range.high[d] >> below;
      count *= last[d] - first[d] + 1;
    }
    if (count > kMostNodes || (nodes_ += count) > kMostNodes) return false;
    CellRange part{range.pair, {}, {}};
    uint32_t at[4];
    const uint32_t mask = (1u << below) - 1;
    const auto enter = [&](int d) {
      part.low[d] = at[d] == first[d] ? range.low[d] & mask : 0;
      part.high[d] = at[d] == last[d] ? range.high[d] & mask : mask;
    };
    for (at[0] = first[0]; at[0] <= last[0]; ++at[0]) {
      enter(0);
      for (at[1] = first[1]; at[1] <= last[1]; ++at[1]) {
        enter(1);
        for (at[2] = first[2]; at[2] <= last[2]; ++at[2]) {
          enter(2);
          for (at[3] = first[3]; at[3] <= last[3]; ++at[3]) {
            enter(3);
            if (!visit(row_major(at[0], at[1], at[2], at[3], 0, bits), part)) return false;
          }
        }
      }
    }
    return true;
  }

  bool visit_block(uint32_t level, uint32_t index, const CellRange& range) {
    if (level == shape_.block_levels) return visit_brick(index, range);
    if (index < kUniformBlocks) return see(index);
    return each_child(
        range, 1 + shape_.block_levels - level,
        [&](uint32_t at, const CellRange& part) {
          return visit_block(level + 1, tree_.blocks[level][size_t{index} * kBlockWords + at], part);
        },
        1);
  }

  // A word of a brick holds the sixteen cells of one s and t, a byte of it the four of one u.
  bool visit_brick(uint32_t index, const CellRange& range) {
    if (index < kUniformBlocks) return see(index);
    const uint32_t row = (4u << (2 * range.high[3])) - (1u << (2 * range.low[3]));
    const auto rows =
        static_cast<uint32_t>((uint64_t{256} << (8 * range.high[2])) - (uint64_t{1} << (8 * range.low[2])));
    const uint32_t cells = row * 0x01010101u & rows, low_bits = cells & 0x55555555u;
    uint32_t any = 0, all = ~0u;
    for (uint32_t s = range.low[0]; s <= range.high[0]; ++s)
      for (uint32_t t = range.low[1]; t <= range.high[1]; ++t) {
        uint32_t word;
        std::memcpy(&word, tree_.bricks + size_t{index} * kBrickBytes + 4 * (4 * s + t), sizeof word);
        any |= word, all &= word;
      }
    const bool some_high = (any & cells & ~low_bits) != 0;
    if ((any & cells) == 0) return see(0);
    if ((all & low_bits) == low_bits && (!some_high || statistics_count_)) return see(1);
    return see(2);
  }

  // False: nothing can be said any more.
  bool see(uint32_t value) {
    seen_clear_ |= value == 0;
    seen_blocked_ |= value == 1;
    seen_unclassified_ |= value == 2;
    return !seen_unclassified_ && !(seen_clear_ && seen_blocked_);
  }

  static constexpr uint32_t kMostNodes = 64;
  const TreeView& tree_;
  TreeShape shape_;
  bool statistics_count_;
  uint32_t nodes_ = 0;
  bool seen_clear_ = false, seen_blocked_ = false, seen_unclassified_ = false;
};

}  // namespace

Visibility range_class(const TreeView& tree, const CellRange& range) { return Reader(tree).classify(range); }

}  // namespace vcd
