// What queries of one object need.
#pragma once

#include <string_view>

#include <vcd/format/layout.h>
#include <vcd/format/segment.h>
#include <vcd/format/tree.h>

#include "hierarchy/traced.h"
#include "horizon/above.h"
#include "lookup/kernels.h"
#include "lookup/to_grid.h"

namespace vcd {

struct ObjectData {
  GridFrame frame;
  TreeView tree;
  Visibility (*classify_one)(const GridFrame&, const TreeView&, const Segment&) noexcept;
  Visibility (*classify_placed)(const TreeView&, const PlacedSegment&) noexcept;  // of an instance
  const Kernels* kernels;  // null: every segment is unclassified, whatever the tree says
  const ObjectRecord* record;
  std::string_view name;
  ReachBox box;   // of the record: what passes it by, a look-up calls clear too (spec/proofs.md, "The hierarchy")
  Traced traced;  // its hierarchy, if it has one
  const TraceKernels* trace;
  Horizons horizons;  // those of that hierarchy, if it has them
  const HorizonKernels* horizon;
  // By From: whether to look up before the hierarchy is asked: arrays, bundles, and segments one by one.
  bool look_up_arrays[3], look_up_bundles[3], look_up_one[3];
  bool look_up_in_scene;  // one by one, where the object is an instance
  // Whether a single segment that misses the hierarchy's own box need not be looked up. Statistics may call it blocked,
  // and arrays and bundles would say so.
  bool box_first;

  LookUp look_up() const { return {&tree, &kernels->at_depth[record->depth - 1u]}; }
};

}  // namespace vcd
