// Hash-consing: equal blocks are stored once.
#pragma once

#include <cstdint>
#include <cstring>
#include <vector>

#include <xxhash.h>

#include <vcd/format/tree.h>

namespace vcd::baker {

static_assert(kBlockBytes == kBrickBytes);

// A pool of blocks or bricks. Equal blocks get equal indices, in the order in which they first come.
class BlockPool {
 public:
  // Returns the block's index and stores it if it is new. words: kBlockWords of them.
  uint32_t intern(const uint32_t* words) {
    if (2 * (count() + 1) > slots_.size()) grow();
    uint32_t& slot = find(words);
    if (slot == kEmpty) {
      slot = static_cast<uint32_t>(count());
      words_.insert(words_.end(), words, words + kBlockWords);
    }
    return slot;
  }

  uint64_t count() const { return words_.size() / kBlockWords; }
  const uint32_t* data() const { return words_.data(); }

  // Gives the words away and forgets the look-up table.
  std::vector<uint32_t> take() {
    slots_ = {};
    return std::move(words_);
  }

 private:
  static constexpr uint32_t kEmpty = 0xFFFFFFFF;

  uint32_t& find(const uint32_t* words) {
    const size_t mask = slots_.size() - 1;
    size_t at = XXH3_64bits(words, kBlockBytes) & mask;
    while (slots_[at] != kEmpty && std::memcmp(&words_[size_t{slots_[at]} * kBlockWords], words, kBlockBytes) != 0)
      at = (at + 1) & mask;
    return slots_[at];
  }
  void grow() {
    slots_.assign(slots_.empty() ? 1024 : 2 * slots_.size(), kEmpty);
    for (uint32_t i = 0; i < count(); ++i) find(&words_[size_t{i} * kBlockWords]) = i;
  }

  std::vector<uint32_t> words_;
  std::vector<uint32_t> slots_;  // open addressing, at most half full
};

}  // namespace vcd::baker
