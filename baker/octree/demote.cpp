#include "demote.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <numeric>
#include <tuple>

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <vcd/baker/cell.h>
#include <vcd/format/layout.h>

#include "classify/random.h"

namespace vcd {
namespace {

using Brick = std::array<uint64_t, 8>;  // 32 cells of two bits a word
constexpr uint64_t kLow = 0x5555555555555555u;

// What both promise: equal classes stay, blocked and statistically blocked give the latter, all else unclassified.
Brick common(const Brick& a, const Brick& b) {
  Brick c;
  for (size_t i = 0; i < c.size(); ++i) {
    const uint64_t x = a[i] ^ b[i], differ = (x | x >> 1) & kLow;
    c[i] = (a[i] & ~(differ * 3)) | differ << 1 | (a[i] & b[i] & differ);
  }
  return c;
}

// What a brick's promises are worth: 4 for a proven cell, 3 for a statistically blocked one.
uint32_t value(const Brick& b) {
  int lost = 0;
  for (uint64_t word : b) {
    const uint64_t high = word >> 1 & kLow, low = word & kLow;
    lost += 4 * std::popcount(high & ~low) + std::popcount(high & low);
  }
  return 1024 - static_cast<uint32_t>(lost);
}

struct Kept {
  Brick brick;
  uint64_t weight;  // places in the tree that it stands for
  uint32_t id;      // the first original brick that it stands for
};

struct Merge {
  uint64_t loss;
  uint32_t first, second;  // of the kept; equal: becomes unclassified
};

// Merges until at most `target` bricks are left. Returns for each original brick the kept one that replaces it; kNone: the
// unclassified one.
class BrickMerger {
 public:
  explicit BrickMerger(std::vector<Kept> kept) : kept_(std::move(kept)), parent_(kept_.size()) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }

  void run(size_t target) {
    for (uint32_t round = 0; kept_.size() > target; ++round) {
      std::vector<Merge> merges = propose(round);
      tbb::parallel_sort(merges.begin(), merges.end(), [](const Merge& a, const Merge& b) {
        return std::tie(a.loss, a.first, a.second) < std::tie(b.loss, b.first, b.second);
      });
      // The cheapest quarter of the proposals, so that dear ones can find a better partner in a later round.
      apply(merges, std::min(kept_.size() - target, std::max<size_t>(merges.size() / 4, 1)));
    }
  }

  // By original brick.
  std::vector<const Brick*> replacements() {
    std::vector<const Brick*> by_id(parent_.size());
    for (const Kept& k : kept_) by_id[k.id] = &k.brick;
    std::vector<const Brick*> result(parent_.size());
    for (uint32_t i = 0; i < parent_.size(); ++i) {
      uint32_t root = i;
      while (root != kNone && parent_[root] != root) root = parent_[root];
      result[i] = root == kNone ? nullptr : by_id[root];
    }
    return result;
  }

 private:
  static constexpr size_t kWindow = 12;

  // For each brick the cheapest partner among its neighbours in an order by some 32 of its cells, others each round
  // (locality-sensitive hashing by sampled coordinates: Indyk and Motwani 1998).
  std::vector<Merge> propose(uint32_t round) const {
    std::array<uint32_t, 32> cells;
    for (uint32_t i = 0; i < cells.size(); ++i) cells[i] = static_cast<uint32_t>(mix_bits(kGolden * (round * 32 + i + 1)) % 256);
    std::vector<std::pair<uint64_t, uint32_t>> order(kept_.size());
    tbb::parallel_for(size_t{0}, order.size(), [&](size_t k) {
      uint64_t key = 0;
      for (uint32_t cell : cells) key = key << 2 | (kept_[k].brick[cell / 32] >> (2 * (cell % 32)) & 3);
      order[k] = {key, static_cast<uint32_t>(k)};
    });
    tbb::parallel_sort(order.begin(), order.end());
    std::vector<Merge> merges(order.size());
    tbb::parallel_for(size_t{0}, order.size(), [&](size_t at) {
      const uint32_t me = order[at].second;
      const Kept& a = kept_[me];
      const uint64_t worth = a.weight * value(a.brick);
      Merge best{worth, me, me};
      for (size_t n = at + 1; n < std::min(order.size(), at + 1 + kWindow); ++n) {
        const Kept& b = kept_[order[n].second];
        const uint64_t loss = worth + b.weight * value(b.brick) - (a.weight + b.weight) * value(common(a.brick, b.brick));
        if (loss < best.loss) best = {loss, me, order[n].second};
      }
      merges[at] = best;
    });
    return merges;
  }

  void apply(const std::vector<Merge>& merges, size_t most) {
    std::vector<bool> touched(kept_.size()), gone(kept_.size());
    for (const Merge& merge : merges) {
      if (most == 0) break;
      if (touched[merge.first] || touched[merge.second]) continue;
      touched[merge.first] = touched[merge.second] = true;
      Kept& a = kept_[merge.first];
      Kept& b = kept_[merge.second];
      gone[merge.second] = true;
      if (merge.first == merge.second) {
        parent_[a.id] = kNone;
      } else {
        parent_[b.id] = a.id;
        a.brick = common(a.brick, b.brick);
        a.weight += b.weight;
      }
      --most;
    }
    size_t left = 0;
    for (size_t k = 0; k < kept_.size(); ++k)
      if (!gone[k]) kept_[left++] = kept_[k];
    kept_.resize(left);
  }

  std::vector<Kept> kept_;
  std::vector<uint32_t> parent_;  // by original brick; kNone: became unclassified
};

// A tree's blocks, with how often each is referred to from the unfolded tree.
struct Weights {
  std::vector<uint64_t> blocks256, blocks16, bricks;
};

Weights weigh(const TreeArrays& tree) {
  const TreeView view = tree.view();
  Weights w{std::vector<uint64_t>(view.block256_count), std::vector<uint64_t>(view.block16_count), std::vector<uint64_t>(view.brick_count)};
  std::vector<uint64_t>& below16 = w.bricks;
  std::vector<uint64_t>& below256 = tree.shape.has_blocks16 ? w.blocks16 : below16;
  std::vector<uint64_t>& below_top = tree.shape.has_blocks256 ? w.blocks256 : below256;
  for (uint32_t i = 0; i < tree.shape.top_words(); ++i) ++below_top[tree.top[i]];
  for (size_t i = 0; i < tree.blocks256.size(); ++i) below256[tree.blocks256[i]] += w.blocks256[i / kBlock256Words];
  for (size_t i = 0; i < tree.blocks16.size(); ++i) below16[tree.blocks16[i]] += w.blocks16[i / kBlock16Words];
  return w;
}

Brick brick_at(const TreeArrays& tree, size_t index) {
  Brick brick;
  std::memcpy(brick.data(), &tree.bricks[index * kBrickBytes / 4], kBrickBytes);
  return brick;
}

// Keeps the blocks that promise most: every other word of `above` that refers to one becomes unclassified.
void prune(std::vector<uint32_t>& above, size_t above_words, const std::vector<double>& worth, size_t keep) {
  std::vector<uint32_t> order(worth.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin() + kUniformBlocks, order.end(),
            [&](uint32_t a, uint32_t b) { return worth[a] != worth[b] ? worth[a] > worth[b] : a < b; });
  std::vector<bool> stays(worth.size());
  for (size_t i = 0; i < std::min(order.size(), keep); ++i) stays[order[i]] = true;
  for (uint32_t i = 0; i < kUniformBlocks; ++i) stays[i] = true;
  for (size_t i = 0; i < above_words; ++i)
    if (!stays[above[i]]) above[i] = kUnclassified;
}

// Blocks may take at most half of what the top table leaves.
void prune_blocks(TreeArrays& tree, uint64_t budget) {
  const uint64_t half = (budget - std::min(budget, tree.shape.top_bytes())) / 2;
  const Weights weights = weigh(tree);
  const TreeView view = tree.view();
  std::vector<double> brick_value(view.brick_count);
  for (size_t i = 0; i < brick_value.size(); ++i) brick_value[i] = value(brick_at(tree, i));
  std::vector<double> value16(view.block16_count), worth16(view.block16_count);
  for (size_t i = 0; i < tree.blocks16.size(); ++i) value16[i / kBlock16Words] += brick_value[tree.blocks16[i]];
  for (size_t i = 0; i < value16.size(); ++i) worth16[i] = value16[i] * static_cast<double>(weights.blocks16[i]);
  if (tree.shape.has_blocks256) {
    const auto& below = tree.shape.has_blocks16 ? value16 : brick_value;
    std::vector<double> worth256(view.block256_count);
    for (size_t i = 0; i < tree.blocks256.size(); ++i) worth256[i / kBlock256Words] += below[tree.blocks256[i]];
    for (size_t i = 0; i < worth256.size(); ++i) worth256[i] *= static_cast<double>(weights.blocks256[i]);
    prune(tree.top, tree.shape.top_words(), worth256, (tree.shape.has_blocks16 ? half / 2 : half) / (kBlock256Words * 4));
    if (tree.shape.has_blocks16) prune(tree.blocks256, tree.blocks256.size(), worth16, half / 2 / (kBlock16Words * 4));
  } else if (tree.shape.has_blocks16) {
    prune(tree.top, tree.shape.top_words(), worth16, half / (kBlock16Words * 4));
  }
}

// The tree again, with each brick replaced (null: unclassified).
TreeArrays rebuild(const TreeArrays& tree, const std::vector<const Brick*>& replacements) {
  DagBuilder builder(tree.depth);
  const size_t bricks = size_t{1} << (4 * (tree.shape.levels - 2 - tree.shape.top_levels));
  for (uint32_t slot = 0; slot < tree.shape.top_words(); ++slot) {
    Subtree subtree;
    subtree.bricks.reserve(bricks);
    const auto add_brick = [&](uint32_t index) {
      if (index < kUniformBlocks || !replacements[index]) return subtree.bricks.push_back(index < kUniformBlocks ? index : kUnclassified);
      subtree.bricks.push_back(kDeeper + static_cast<uint32_t>(subtree.words.size()));
      std::memcpy(subtree.words.emplace_back().data(), replacements[index]->data(), kBrickBytes);
    };
    const auto add_block16 = [&](uint32_t index) {
      if (!tree.shape.has_blocks16) return add_brick(index);
      for (size_t i = 0; i < kBlock16Words; ++i) add_brick(tree.blocks16[index * kBlock16Words + i]);
    };
    if (!tree.shape.has_blocks256) add_block16(tree.top[slot]);
    else
      for (size_t i = 0; i < kBlock256Words; ++i) add_block16(tree.blocks256[tree.top[slot] * kBlock256Words + i]);
    builder.append(subtree);
  }
  return builder.take();
}

uint64_t bytes_of(const TreeArrays& tree) {
  const TreeView view = tree.view();
  return tree.shape.bytes(view.block256_count, view.block16_count, view.brick_count);
}

TreeArrays merge_bricks(const TreeArrays& tree, size_t target) {
  const Weights weights = weigh(tree);
  std::vector<Kept> kept;
  for (uint32_t i = 0; i < weights.bricks.size(); ++i) kept.push_back({brick_at(tree, i), weights.bricks[i], i});
  std::vector<Kept> used(kept.begin() + kUniformBlocks, kept.end());
  for (Kept& k : used) k.id -= kUniformBlocks;
  BrickMerger merger(std::move(used));
  merger.run(target);
  std::vector<const Brick*> replacements = merger.replacements();
  replacements.insert(replacements.begin(), kUniformBlocks, nullptr);
  return rebuild(tree, replacements);
}

}  // namespace

TreeArrays demote_merge(TreeArrays tree, uint64_t budget_bytes) {
  if (bytes_of(tree) <= budget_bytes) return tree;
  prune_blocks(tree, budget_bytes);
  tree = merge_bricks(tree, SIZE_MAX);  // without what nothing refers to any more
  // Merged bricks can turn out uniform or equal, and blocks with them; so the tree often ends below the budget.
  const uint64_t others = bytes_of(tree) - tree.bricks.size() * 4;
  const uint64_t room = budget_bytes > others ? (budget_bytes - others) / kBrickBytes : 0;
  if (bytes_of(tree) <= budget_bytes) return tree;
  return merge_bricks(tree, room > kUniformBlocks ? room - kUniformBlocks : 0);
}

}  // namespace vcd
