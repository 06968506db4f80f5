// Segments of a chunk by instance: those that are left to the caller, or those that begin on it.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "lookup/sample_bits.h"

namespace vcd {

template <size_t kMost>
class BitsByInstance {
 public:
  void clear() { count_ = 0; }
  // False if there is no room for another instance.
  bool add(uint32_t instance, const SampleBits& bits) {
    if (const size_t k = find(instance); k < count_) return bits_[k] |= bits, true;
    if (count_ == kMost) return false;
    instances_[count_] = instance, bits_[count_++] = bits;
    return true;
  }
  SampleBits of(uint32_t instance) const {
    const size_t k = find(instance);
    return k < count_ ? bits_[k] : SampleBits{};
  }
  template <class Visit>
  void for_each(const Visit& visit) const {
    for (size_t k = 0; k < count_; ++k) visit(instances_[k], bits_[k]);
  }
  // visit(instance, bits), those with most bits first; then there are none.
  template <class Visit>
  void take(const Visit& visit) {
    std::array<std::pair<int, uint32_t>, kMost> order;
    for (uint32_t k = 0; k < count_; ++k) order[k] = {-bits_[k].count(), k};
    std::sort(order.begin(), order.begin() + count_);
    for (size_t k = 0; k < count_; ++k) visit(instances_[order[k].second], bits_[order[k].second]);
    count_ = 0;
  }

 private:
  size_t find(uint32_t instance) const {
    const auto end = instances_.begin() + static_cast<std::ptrdiff_t>(count_);
    return static_cast<size_t>(std::find(instances_.begin(), end, instance) - instances_.begin());
  }

  std::array<uint32_t, kMost> instances_;
  std::array<SampleBits, kMost> bits_;
  size_t count_ = 0;
};

}  // namespace vcd
