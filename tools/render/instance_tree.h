// A hierarchy over the boxes of instances, and which of them a bundle of shadow rays could meet.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <vcd/format/segment.h>

#include "vec.h"

namespace vcd {

// All points origin + t · direction with 0 ≤ t ≤ 1 and the direction in the box about the directions of some segments that
// begin at one point.
class Beam {
 public:
  explicit Beam(std::span<const Segment> segments);  // at least one

  // False only if no segment of the beam meets the box, but for rounding.
  bool may_meet(const Box& box) const;

 private:
  struct Bound {   // a direction component's end: t · slope against an offset from the origin
    float slope, inverse;
  };
  Vec3 origin_;
  Bound low_[3], high_[3];
};

class InstanceTree {
 public:
  explicit InstanceTree(std::span<const Box> boxes);

  // Calls visit(index) for every box that the beam may meet, near ones not necessarily first.
  template <class Visit>
  void visit(const Beam& beam, const Visit& visit) const {
    uint32_t stack[64], size = 0;  // the tree is balanced: never more than log2(boxes) + 1
    if (!nodes_.empty()) stack[size++] = 0;
    while (size > 0) {
      const Node& node = nodes_[stack[--size]];
      if (!beam.may_meet(node.box)) continue;
      if (node.instance != kInterior) {
        visit(node.instance);
      } else {
        stack[size++] = node.second;
        stack[size++] = static_cast<uint32_t>(&node - nodes_.data()) + 1;
      }
    }
  }

 private:
  static constexpr uint32_t kInterior = 0xFFFFFFFF;
  struct Node {
    Box box;
    uint32_t second;    // the first child follows its parent
    uint32_t instance;  // of a leaf, else kInterior
  };
  void build(std::span<const Box> boxes, std::span<uint32_t> order);
  std::vector<Node> nodes_;
};

}  // namespace vcd
