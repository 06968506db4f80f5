// The tree of one object as it lies in memory and in the file: how a cell's class is found.
// Normative text: spec/vcd-format.md, "TREE section".
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <vcd/format/answer.h>
#include <vcd/format/layout.h>
#include <vcd/format/line_cell.h>
#include <vcd/format/segment.h>

namespace vcd {

inline constexpr uint32_t kMinDepth = 1;
inline constexpr uint32_t kMaxDepth = 8;

inline constexpr size_t kBrickBytes = 64;  // 256 cells × 2 bits
inline constexpr size_t kBlockWords = 16;
inline constexpr size_t kBlockBytes = kBlockWords * 4;

// Index 0, 1 and 2 of every pool is the uniform clear, blocked and unclassified block.
inline constexpr uint32_t kUniformBlocks = 3;

// How many levels each part of the tree resolves, for an object of the given depth (1 … 8).
// Depth 1 is stored as depth 2 with every cell repeated, so a brick always holds two levels.
struct TreeShape {
  uint32_t levels;        // stored levels, max(depth, 2)
  uint32_t top_levels;    // 0 … 3
  uint32_t block_levels;  // 0 … 3: between the top table and the bricks, a block of 16 words resolves one level

  constexpr uint32_t top_words() const { return kFacePairs << (4 * top_levels); }  // without the spare slot
  constexpr uint64_t top_bytes() const { return ((uint64_t{top_words()} + 1) * 4 + 63) & ~uint64_t{63}; }
  constexpr uint64_t bytes(const std::array<uint32_t, kMostBlockLevels>& block_counts, uint64_t brick_count) const {
    uint64_t sum = top_bytes() + brick_count * kBrickBytes;
    for (const uint64_t count : block_counts) sum += count * kBlockBytes;
    return sum;
  }
  // Of a tree with nothing but uniform blocks.
  constexpr uint64_t least_bytes() const {
    return top_bytes() + (block_levels * kBlockBytes + kBrickBytes) * kUniformBlocks;
  }
  constexpr uint64_t cells() const { return uint64_t{kFacePairs} << (4 * levels); }
};
constexpr TreeShape tree_shape(uint32_t depth) {
  const uint32_t levels = depth < 2 ? 2 : depth;
  const uint32_t top = levels - 2 < 3 ? levels - 2 : 3;
  return {levels, top, levels - 2 - top};
}

// A tree in place. Every word of the top table is an index into the first pool of blocks that the shape has, every word
// of that pool into the next, and the last into bricks. In a file all arrays are 64-byte aligned, so that a block or a
// brick is one cache line.
struct TreeView {
  TreeShape shape{};
  const uint32_t* top = nullptr;  // top_words() words, and one spare word that is 0: lines that miss the box
  std::array<const uint32_t*, kMostBlockLevels> blocks{};  // of the first shape.block_levels: count * 16 words
  const uint8_t* bricks = nullptr;                         // count * 64 bytes
  std::array<uint32_t, kMostBlockLevels> block_counts{};   // 0 beyond shape.block_levels
  uint32_t brick_count = 0;
  const uint8_t* clearances = nullptr;  // kClearanceBytes bytes, 4-byte aligned; null: none are known
  AnswerTable answers = answer_table(Trust::proofs);

  constexpr uint64_t bytes() const { return shape.bytes(block_counts, brick_count); }
};

// The classes that an object's record counts cells of.
inline ClassSet classes_in(const ObjectRecord& record) {
  ClassSet present = record.statistical_cells != 0 ? just(CellClass::statistically_blocked) : 0;
  for (uint32_t c = 0; c < 3; ++c)
    if (record.cells[c] != 0) present |= just(static_cast<CellClass>(c));
  return present;
}

// Row-major index of the `bits` bits above bit `low` of each of s, t, u, v.
inline uint32_t row_major(uint32_t s, uint32_t t, uint32_t u, uint32_t v, uint32_t low, uint32_t bits) {
  const uint32_t mask = (1u << bits) - 1;
  uint32_t index = (s >> low) & mask;
  index = index << bits | ((t >> low) & mask);
  index = index << bits | ((u >> low) & mask);
  return index << bits | ((v >> low) & mask);
}

inline uint32_t top_slot(TreeShape shape, const LineCell& line) {
  const uint32_t bits = shape.top_levels;
  return line.pair << (4 * bits) | row_major(line.s, line.t, line.u, line.v, 8 - bits, bits);
}

// Cell i stands in byte i / 4 at bit 2 * (i % 4).
inline CellClass brick_cell(const uint8_t* brick, uint32_t cell) {
  return static_cast<CellClass>(brick[cell >> 2] >> (2 * (cell & 3)) & 3u);
}

// The class of the cell that is reached from one top slot and the line's s, t, u, v.
[[gnu::always_inline]] inline CellClass class_from_slot(const TreeView& tree, TreeShape shape, uint32_t slot,
                                                        const LineCell& line) {
  uint32_t index = tree.top[slot];
  uint32_t low = 8 - shape.top_levels;  // bits of each coordinate that are left
  for (uint32_t k = 0; k < shape.block_levels; ++k) {
    low -= 1;
    index = tree.blocks[k][size_t{index} * kBlockWords + row_major(line.s, line.t, line.u, line.v, low, 1)];
  }
  const uint8_t* brick = tree.bricks + size_t{index} * kBrickBytes;
  return brick_cell(brick, row_major(line.s, line.t, line.u, line.v, low - 2, 2));
}
inline CellClass class_of(const TreeView& tree, const LineCell& line) {
  return class_from_slot(tree, tree.shape, top_slot(tree.shape, line), line);
}

// The answer to a segment of this line that stands so to the box. The tree is not read where its cells do not matter.
// shape is tree.shape; pass it as a constant and everything that depends on the depth folds away. The branch is for
// what is rare; everything that varies from segment to segment is arithmetic.
[[gnu::always_inline]] inline Visibility look_up(const TreeView& tree, TreeShape shape, Place place,
                                                 const LineCell& line) {
  const uint32_t row = tree.answers.row(place);
  if (row == AnswerTable::kAllUnclassified) return Visibility::unclassified;
  const uint32_t slot = top_slot(shape, line), spare = shape.top_words(), outside = place == Place::outside;
  return AnswerTable::of_row(row, class_from_slot(tree, shape, slot ^ ((slot ^ spare) & (0u - outside)), line));
}

// What a segment in the object's own frame is answered. No allocation, no exception. shape: as above.
[[gnu::always_inline]] inline Visibility classify(const GridFrame& frame, const TreeView& tree, TreeShape shape,
                                                  const Segment& segment) {
  const LineCell line = locate(frame, segment);
  const Place place = place_of(line, segment.t_min, segment.t_max);
  return look_up(tree, shape, widened(place, tree.clearances, line, segment.t_min, segment.t_max), line);
}

}  // namespace vcd
