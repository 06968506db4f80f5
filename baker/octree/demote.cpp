#include "demote.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>
#include <tuple>
#include <utility>

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <vcd/baker/cell.h>
#include <vcd/baker/threads.h>
#include <vcd/format/layout.h>

#include "classify/random.h"
#include "octree/block_pool.h"

namespace vcd::baker {
namespace {

constexpr uint32_t kLow = 0x55555555u;  // the low bits of the sixteen cells of a word

struct Counts {
  uint32_t clear = 0, blocked = 0, statistical = 0;
  uint32_t classified() const { return clear + blocked + statistical; }
  uint64_t value() const { return 4 * (uint64_t{clear} + blocked) + 3 * uint64_t{statistical}; }
  void operator+=(const Counts& o) { clear += o.clear, blocked += o.blocked, statistical += o.statistical; }
};

Counts count_word(uint32_t word) {
  const uint32_t high = word >> 1 & kLow, low = word & kLow;
  const auto ones = [](uint32_t bits) { return static_cast<uint32_t>(std::popcount(bits)); };
  return {ones(~(high | low) & kLow), ones(low & ~high), ones(low & high)};
}

// What both promise: equal classes stay, blocked and statistically blocked give the latter, all else unclassified.
uint32_t common_word(uint32_t a, uint32_t b) {
  const uint32_t x = a ^ b, differ = (x | x >> 1) & kLow;
  return (a & ~(differ * 3)) | differ << 1 | (a & b & differ);
}

struct Level {  // 0: bricks; above: the levels of blocks that the shape has, lowest first
  std::vector<uint32_t> words;
  uint64_t cells;              // that a block stands for
  std::vector<Counts> counts;  // of each block

  size_t size() const { return words.size() / kBlockWords; }
  const uint32_t* block(size_t index) const { return &words[index * kBlockWords]; }
};
using Words = std::array<uint32_t, kBlockWords>;

// A tree whose blocks can be compared, joined and replaced.
class Merger {
 public:
  explicit Merger(TreeArrays&& tree) : depth_(tree.depth), shape_(tree.shape), top_(std::move(tree.top)) {
    levels_.push_back({std::move(tree.bricks), 256, {}});
    for (uint32_t k = shape_.block_levels; k-- > 0;)
      levels_.push_back({std::move(tree.blocks[k]), 16 * levels_.back().cells, {}});
    count();
  }

  TreeArrays take() {
    TreeArrays tree{depth_, shape_, std::move(top_), {}, std::move(levels_[0].words)};
    for (size_t l = 1; l < levels_.size(); ++l) tree.blocks[levels_.size() - 1 - l] = std::move(levels_[l].words);
    return tree;
  }

  uint64_t classified() const {
    uint64_t cells = 0;
    for (uint32_t slot = 0; slot < shape_.top_words(); ++slot) cells += levels_.back().counts[top_[slot]].classified();
    return cells;
  }

  // From the largest blocks down: a level is merged until it takes no more than its share, or the tree fits.
  void run(uint64_t budget) {
    for (size_t l = levels_.size(); l-- > 0;) {
      for (uint32_t round = 0; bytes() > budget; ++round) {
        const uint64_t most = most_blocks(l, budget);
        if (levels_[l].size() <= most) break;
        if (most <= kUniformBlocks) forget(l);
        else merge(l, levels_[l].size() - most, round);
      }
    }
  }

 private:
  static constexpr size_t kWindow = 12;
  static constexpr uint32_t kNew = 0xFFFFFFFF;

  struct Merge {
    uint64_t loss;
    uint32_t first, second;  // equal: becomes unclassified
  };

  uint64_t bytes() const {
    uint64_t sum = shape_.top_bytes();
    for (const Level& level : levels_) sum += level.words.size() * 4;
    return sum;
  }

  // Of what the levels above leave, a level of blocks may take 55 %, bricks all. Measured where there is one such
  // level; a tenth more or less changes little.
  uint64_t most_blocks(size_t l, uint64_t budget) const {
    uint64_t least = shape_.top_bytes();
    for (size_t k = 0; k < levels_.size(); ++k) least += (k > l ? levels_[k].size() : kUniformBlocks) * kBlockBytes;
    const uint64_t percent = l == 0 ? 100 : 55;
    return kUniformBlocks + (budget - std::min(budget, least)) * percent / 100 / kBlockBytes;
  }

  Counts count_block(size_t l, const uint32_t* words) const {
    Counts sum;
    for (uint32_t i = 0; i < kBlockWords; ++i) sum += l == 0 ? count_word(words[i]) : levels_[l - 1].counts[words[i]];
    return sum;
  }
  void count() {
    for (size_t l = 0; l < levels_.size(); ++l) {
      levels_[l].counts.resize(levels_[l].size());
      const auto count_one = [&](size_t i) { levels_[l].counts[i] = count_block(l, levels_[l].block(i)); };
      tbb::parallel_for(size_t{0}, levels_[l].size(), count_one);
    }
  }

  // How many places of the unfolded tree each block of a level stands for.
  std::vector<uint64_t> weights(size_t l) const {
    std::vector<uint64_t> above(levels_.back().size());
    for (uint32_t slot = 0; slot < shape_.top_words(); ++slot) ++above[top_[slot]];
    for (size_t k = levels_.size() - 1; k > l; --k) {
      std::vector<uint64_t> below(levels_[k - 1].size());
      for (size_t i = 0; i < levels_[k].words.size(); ++i) below[levels_[k].words[i]] += above[i / kBlockWords];
      above.swap(below);
    }
    return above;
  }

  // The value of what two blocks both promise.
  uint64_t common_value(size_t l, uint32_t a, uint32_t b) const {
    if (a > b) std::swap(a, b);
    const Level& level = levels_[l];
    if (a == b) return level.counts[a].value();
    if (a == kUnclassified || b == kUnclassified) return 0;
    if (a == kClear) return 4 * uint64_t{level.counts[b].clear};
    if (a == kBlocked) return 4 * uint64_t{level.counts[b].blocked} + 3 * uint64_t{level.counts[b].statistical};
    const uint32_t *p = level.block(a), *q = level.block(b);
    uint64_t sum = 0;
    if (l > 0) {
      for (uint32_t i = 0; i < kBlockWords; ++i) sum += common_value(l - 1, p[i], q[i]);
    } else {
      Counts counts;
      for (uint32_t i = 0; i < kBlockWords; ++i) counts += count_word(common_word(p[i], q[i]));
      sum = counts.value();
    }
    return sum;
  }

  // The block that promises what two do; new blocks go to the end of their pools.
  uint32_t common(size_t l, uint32_t a, uint32_t b) {
    if (a == b) return a;
    if (a == kUnclassified || b == kUnclassified) return kUnclassified;
    Words words;
    for (uint32_t i = 0; i < kBlockWords; ++i) {
      const uint32_t x = levels_[l].block(a)[i], y = levels_[l].block(b)[i];
      words[i] = l == 0 ? common_word(x, y) : common(l - 1, x, y);
    }
    for (uint32_t old : {a, b})
      if (std::equal(words.begin(), words.end(), levels_[l].block(old))) return old;
    const uint32_t unclassified = l == 0 ? 2 * kLow : kUnclassified;
    if (std::ranges::count(words, unclassified) == kBlockWords) return kUnclassified;
    levels_[l].words.insert(levels_[l].words.end(), words.begin(), words.end());
    levels_[l].counts.push_back(count_block(l, words.data()));
    return static_cast<uint32_t>(levels_[l].size() - 1);
  }

  uint32_t cell(size_t l, uint32_t index, uint64_t at) const {
    for (; l > 0; --l) {
      const uint64_t below = levels_[l - 1].cells;
      index = levels_[l].block(index)[at / below];
      at %= below;
    }
    return levels_[0].block(index)[at / 16] >> (2 * (at % 16)) & 3;
  }

  // For each block the cheapest partner among its next ones in an order by some 32 of its cells, others each round
  // (locality-sensitive hashing by sampled coordinates: Indyk and Motwani 1998).
  std::vector<Merge> propose(size_t l, uint32_t round) const {
    const Level& level = levels_[l];
    const std::vector<uint64_t> weight = weights(l);
    std::array<uint64_t, 32> cells;
    for (uint32_t i = 0; i < cells.size(); ++i) cells[i] = mix_bits(kGolden * (round * 32 + i + 1)) % level.cells;
    std::vector<std::pair<uint64_t, uint32_t>> order(level.size() - kUniformBlocks);
    tbb::parallel_for(size_t{0}, order.size(), [&](size_t k) {
      const uint32_t index = static_cast<uint32_t>(k) + kUniformBlocks;
      uint64_t key = 0;
      for (uint64_t at : cells) key = key << 2 | cell(l, index, at);
      order[k] = {key, index};
    });
    tbb::parallel_sort(order.begin(), order.end());
    std::vector<Merge> merges(order.size());
    tbb::parallel_for(size_t{0}, order.size(), [&](size_t k) {
      const uint32_t a = order[k].second;
      const uint64_t worth = weight[a] * level.counts[a].value();
      Merge best{worth, a, a};
      for (size_t n = k + 1; n < std::min(order.size(), k + 1 + kWindow); ++n) {
        const uint32_t b = order[n].second;
        const uint64_t kept = (weight[a] + weight[b]) * common_value(l, a, b);
        best = std::min(best, {worth + weight[b] * level.counts[b].value() - kept, a, b}, cheaper);
      }
      merges[k] = best;
    });
    return merges;
  }
  static bool cheaper(const Merge& a, const Merge& b) {
    return std::tie(a.loss, a.first, a.second) < std::tie(b.loss, b.first, b.second);
  }

  // One round: the cheapest eighth of the proposals, so that dear ones can find a better partner in a later one.
  void merge(size_t l, size_t most, uint32_t round) {
    std::vector<Merge> merges = propose(l, round);
    tbb::parallel_sort(merges.begin(), merges.end(), cheaper);
    most = std::min(most, std::max<size_t>(merges.size() / 8, 1));
    std::vector<uint32_t> replacement(levels_[l].size(), kNew);
    for (const Merge& m : merges) {
      if (most == 0) break;
      if (replacement[m.first] != kNew || replacement[m.second] != kNew) continue;
      replacement[m.first] = replacement[m.second] = m.first == m.second ? kUnclassified : common(l, m.first, m.second);
      --most;
    }
    for (uint32_t i = 0; i < replacement.size(); ++i)
      if (replacement[i] == kNew) replacement[i] = i;
    rebuild(l, replacement);
  }

  // Every block of the level that is not uniform becomes unclassified.
  void forget(size_t l) {
    std::vector<uint32_t> replacement(levels_[l].size(), kUnclassified);
    std::iota(replacement.begin(), replacement.begin() + kUniformBlocks, 0u);
    rebuild(l, replacement);
  }

  // Every block once, in the order in which the top table first reaches them, with those of one level replaced.
  void rebuild(size_t level, const std::vector<uint32_t>& replacement) {
    std::vector<BlockPool> pools(levels_.size());
    std::vector<std::vector<uint32_t>> seen(levels_.size());
    for (size_t l = 0; l < levels_.size(); ++l) {
      seen[l].assign(levels_[l].size(), kNew);
      for (uint32_t i = 0; i < kUniformBlocks; ++i) seen[l][i] = pools[l].intern(levels_[l].block(i));
    }
    const auto copy = [&](const auto& self, size_t l, uint32_t index) -> uint32_t {
      if (l == level) index = replacement[index];
      uint32_t& now = seen[l][index];
      if (now != kNew) return now;
      if (l == 0) return now = pools[l].intern(levels_[l].block(index));
      Words words;
      for (uint32_t i = 0; i < kBlockWords; ++i) words[i] = self(self, l - 1, levels_[l].block(index)[i]);
      return now = pools[l].intern(words.data());
    };
    for (uint32_t slot = 0; slot < shape_.top_words(); ++slot) top_[slot] = copy(copy, levels_.size() - 1, top_[slot]);
    for (size_t l = 0; l < levels_.size(); ++l) levels_[l].words = pools[l].take();
    count();
  }

  uint32_t depth_;
  TreeShape shape_;
  std::vector<uint32_t> top_;
  std::vector<Level> levels_;
};

}  // namespace

Demoted demote_merge(TreeArrays tree, uint64_t budget_bytes, unsigned threads) {
  if (tree.view().bytes() <= budget_bytes) return {std::move(tree)};
  return with_threads(threads, [&] {
    Merger merger(std::move(tree));
    const uint64_t before = merger.classified();
    merger.run(budget_bytes);
    const uint64_t after = merger.classified();
    return Demoted{merger.take(), before - after};
  });
}

}  // namespace vcd::baker
