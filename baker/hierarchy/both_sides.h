// Recursion over a binary tree on many threads.
#pragma once

#include <cstdint>

#include <tbb/parallel_invoke.h>

namespace vcd::baker {

constexpr uint32_t kOwnTask = 2048;  // triangles of a subtree that is worth a task of its own

// left() and right(), of a subtree of so many triangles.
template <class Left, class Right>
void both_sides(uint32_t triangles, const Left& left, const Right& right) {
  if (triangles >= kOwnTask) {
    tbb::parallel_invoke(left, right);
  } else {
    left(), right();
  }
}

}  // namespace vcd::baker
