// What a query of one object needs, in one place.
#pragma once

#include <span>
#include <string_view>

#include <vcd/format/layout.h>
#include <vcd/format/tree.h>

#include "kernels.h"

namespace vcd {

struct ObjectData {
  GridFrame frame;
  TreeView tree;
  const ObjectRecord* record;
  std::string_view name;
  // For the object's depth.
  Visibility (*classify_one)(const ObjectData&, const Segment&) noexcept;
  ManyKernels many;
};

}  // namespace vcd
