// Integers of up to kMostBits bits with a sign, on the stack: just what the exact test of segments needs.
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <compare>
#include <cstddef>
#include <cstdint>

namespace vcd {

class Integer {
 public:
  static constexpr size_t kMostBits = 2304;

  Integer() = default;  // 0
  // value · 2^shift, or its negative. value is not 0, unless shift is.
  Integer(uint32_t value, unsigned shift, bool negative) : negative_(negative) {
    const size_t word = shift / 32;
    assert(word + 2 <= kWords);
    std::fill_n(words_.begin(), word, 0u);
    const uint64_t wide = static_cast<uint64_t>(value) << shift % 32;
    words_[word] = static_cast<uint32_t>(wide), words_[word + 1] = static_cast<uint32_t>(wide >> 32);
    size_ = word + 2;
    trim();
  }
  Integer(const Integer& other) : size_(other.size_), negative_(other.negative_) {
    std::copy_n(other.words_.begin(), size_, words_.begin());
  }
  Integer& operator=(const Integer& other) {
    size_ = other.size_, negative_ = other.negative_;
    std::copy_n(other.words_.begin(), size_, words_.begin());
    return *this;
  }

  int sign() const { return size_ == 0 ? 0 : negative_ ? -1 : 1; }

  Integer operator-() const {
    Integer r = *this;
    r.negative_ = size_ != 0 && !negative_;
    return r;
  }
  friend Integer operator+(const Integer& a, const Integer& b) { return add(a, b, b.negative_); }
  friend Integer operator-(const Integer& a, const Integer& b) { return add(a, b, !b.negative_); }
  friend Integer operator*(const Integer& a, const Integer& b) {
    Integer r;
    if (a.size_ == 0 || b.size_ == 0) return r;
    r.size_ = a.size_ + b.size_, r.negative_ = a.negative_ != b.negative_;
    assert(r.size_ <= kWords);
    std::fill_n(r.words_.begin(), r.size_, 0u);
    for (size_t i = 0; i < a.size_; ++i) {
      uint64_t carry = 0;
      for (size_t j = 0; j < b.size_; ++j) {
        carry += static_cast<uint64_t>(a.words_[i]) * b.words_[j] + r.words_[i + j];
        r.words_[i + j] = static_cast<uint32_t>(carry);
        carry >>= 32;
      }
      r.words_[i + b.size_] = static_cast<uint32_t>(carry);
    }
    r.trim();
    return r;
  }
  friend bool operator<(const Integer& a, const Integer& b) { return (a - b).sign() < 0; }

 private:
  static constexpr size_t kWords = kMostBits / 32;

  static bool less_magnitude(const Integer& a, const Integer& b) {
    if (a.size_ != b.size_) return a.size_ < b.size_;
    for (size_t i = a.size_; i-- > 0;)
      if (a.words_[i] != b.words_[i]) return a.words_[i] < b.words_[i];
    return false;
  }

  // a plus the magnitude of b with another sign.
  static Integer add(const Integer& a, const Integer& b, bool b_negative) {
    Integer r;
    const bool swap = less_magnitude(a, b);
    const Integer &large = swap ? b : a, &small = swap ? a : b;
    const bool same = a.negative_ == b_negative || a.size_ == 0 || b.size_ == 0;
    r.negative_ = swap ? b_negative : a.negative_;
    uint64_t carry = 0;
    for (size_t i = 0; i < large.size_; ++i) {
      const uint64_t s = i < small.size_ ? small.words_[i] : 0;
      carry = same ? large.words_[i] + s + carry : large.words_[i] - s - carry;
      r.words_[i] = static_cast<uint32_t>(carry);
      carry = same ? carry >> 32 : carry >> 63;
    }
    r.size_ = large.size_;
    if (carry != 0) {
      assert(r.size_ < kWords);
      r.words_[r.size_++] = 1;
    }
    r.trim();
    return r;
  }

  void trim() {
    while (size_ > 0 && words_[size_ - 1] == 0) --size_;
    if (size_ == 0) negative_ = false;
  }

  std::array<uint32_t, kWords> words_;  // only the first size_ have a value
  size_t size_ = 0;
  bool negative_ = false;
};

}  // namespace vcd
