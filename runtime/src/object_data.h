// What a query of one object needs, in one place.
#pragma once

#include <span>
#include <string_view>

#include <vcd/format/layout.h>
#include <vcd/format/tree.h>
#include <vcd/runtime/segment_arrays.h>

#include "array_kernels.h"

namespace vcd {

struct ObjectData {
  GridFrame frame;
  TreeView tree;
  const ObjectRecord* record;
  std::string_view name;
  // The kernels for the object's depth; null: everything is unclassified.
  Visibility (*classify_one)(const ObjectData&, const Segment&) noexcept;
  ClassifySegments classify_segments;
  ClassifyArrays classify_arrays;
};

}  // namespace vcd
