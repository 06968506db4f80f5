// A bit for each segment of a chunk, or of less: SampleBits{} has none set. Bundles and arrays are answered a chunk at
// a time, and within it a run at a time.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>

#include <vcd/format/segment.h>

namespace vcd {

inline constexpr size_t kRun = 16, kChunk = 256, kRuns = kChunk / kRun;

inline constexpr size_t words_for(size_t segments) { return (segments + 63) / 64; }

// Whether a span has room for a bit for each of the segments.
inline bool has_words_for(size_t segments, std::span<const uint64_t> bits) {
  return bits.size() >= words_for(segments);
}

template <size_t kCapacity>
class BitSet {
 public:
  static BitSet first(size_t count) {
    BitSet bits{};
    for (size_t w = 0; w < kWords && 64 * w < count; ++w)
      bits.words_[w] = ~uint64_t{0} >> (64 - std::min<size_t>(64, count - 64 * w));
    return bits;
  }
  template <size_t kCount>
  static BitSet of(const uint64_t (&words)[kCount]) {
    static_assert(kCount == kWords);
    BitSet bits;
    std::copy_n(words, kWords, bits.words_.begin());
    return bits;
  }
  static BitSet just(size_t i) {
    BitSet bits{};
    bits.set(i);
    return bits;
  }

  void set(size_t i, bool value = true) { words_[i / 64] |= uint64_t{value} << (i % 64); }
  // The bits of one run, lowest first.
  void add_run(size_t r, uint64_t bits) { words_[r * kRun / 64] |= bits << (r * kRun % 64); }
  void add_word(size_t w, uint64_t bits) { words_[w] |= bits; }
  uint64_t word(size_t w) const { return words_[w]; }
  uint64_t run(size_t r) const { return words_[r * kRun / 64] >> (r * kRun % 64) & 0xFFFF; }
  // Bit r: whether run r has a bit.
  uint32_t runs() const {
    uint32_t some = 0;
    for (size_t r = 0; r < kCapacity / kRun; ++r) some |= uint32_t{run(r) != 0} << r;
    return some;
  }

  bool operator==(const BitSet&) const = default;

  bool any() const {
    return std::any_of(words_.begin(), words_.end(), [](uint64_t w) { return w != 0; });
  }
  // The first that is set; there must be one.
  size_t lowest() const {
    size_t w = 0;
    while (words_[w] == 0) ++w;
    return 64 * w + static_cast<size_t>(std::countr_zero(words_[w]));
  }
  int count() const {
    int sum = 0;
    for (uint64_t w : words_) sum += std::popcount(w);
    return sum;
  }
  // The places of the set bits, lowest first. (A loop over them, unlike a lambda for each, is compiled for the
  // instructions of the function that it stands in.)
  class Iterator {
   public:
    explicit Iterator(const BitSet& bits) : bits_(bits), left_(bits.words_[0]) { skip(); }
    size_t operator*() const { return 64 * word_ + static_cast<size_t>(std::countr_zero(left_)); }
    Iterator& operator++() {
      left_ &= left_ - 1;
      skip();
      return *this;
    }
    bool operator==(std::default_sentinel_t) const { return left_ == 0; }

   private:
    void skip() {
      while (left_ == 0 && ++word_ < kWords) left_ = bits_.words_[word_];
    }
    const BitSet& bits_;
    size_t word_ = 0;
    uint64_t left_;
  };
  Iterator begin() const { return Iterator(*this); }
  std::default_sentinel_t end() const { return {}; }

  BitSet& operator|=(const BitSet& other) {
    for (size_t w = 0; w < kWords; ++w) words_[w] |= other.words_[w];
    return *this;
  }
  // Those of a smaller set.
  template <size_t kOther>
  void add(const BitSet<kOther>& other) {
    static_assert(kOther <= kCapacity);
    for (size_t w = 0; w < kOther / 64; ++w) words_[w] |= other.word(w);
  }
  BitSet& operator&=(const BitSet& other) {
    for (size_t w = 0; w < kWords; ++w) words_[w] &= other.words_[w];
    return *this;
  }
  BitSet operator&(const BitSet& other) const {
    BitSet bits = *this;
    return bits &= other;
  }
  BitSet without(const BitSet& other) const {
    BitSet bits = *this;
    for (size_t w = 0; w < kWords; ++w) bits.words_[w] &= ~other.words_[w];
    return bits;
  }

  // The first `count` bits, count <= kCapacity, as whole words.
  void store(size_t count, uint64_t* into) const { std::copy_n(words_.begin(), words_for(count), into); }

 private:
  static constexpr size_t kWords = kCapacity / 64;
  std::array<uint64_t, kWords> words_;
};

using SampleBits = BitSet<kChunk>;

// The answers to a chunk; clear where neither bit is set.
struct SampleAnswers {
  SampleBits blocked{}, unclassified{};

  void set(size_t i, Visibility answer) {
    blocked.set(i, answer == Visibility::blocked);
    unclassified.set(i, answer == Visibility::unclassified);
  }
};

}  // namespace vcd
