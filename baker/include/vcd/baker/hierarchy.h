// The hierarchy of boxes over an object's triangles, as the HIER section holds it: <vcd/format/hierarchy.h>.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include <vcd/baker/prepare.h>
#include <vcd/format/hierarchy.h>

namespace vcd::baker {

struct alignas(kUnitBytes) HierarchyUnit {
  std::byte bytes[kUnitBytes];
};
using HierarchySection = std::vector<HierarchyUnit>;

inline Bytes bytes_of(const HierarchySection& section) { return std::as_bytes(std::span(section)); }
inline HierarchyView view_of(const HierarchySection& section) {
  return {section.empty() ? nullptr : bytes_of(section).data()};
}

// Whether an object's coordinates are in the range that a hierarchy may have.
bool can_have_hierarchy(const PreparedMesh& mesh);

// Builds the hierarchy of a mesh that can have one: its triangles, each once, and nothing else. The same geometry gives
// the same bytes, whatever the number of threads, as long as none flushes subnormal numbers. Nothing if it was stopped;
// an empty section if it would be too large for the format. Throws std::bad_alloc. Safe from any thread; for a number
// of threads, call it within with_threads(), which
// also keeps the modes of floats that other users of TBB, such as Embree, leave to its threads out of it.
//
// stop: asked often, from many threads at once; may be empty.
std::optional<HierarchySection> build_hierarchy(const PreparedMesh& mesh, const std::function<bool()>& stop = {});

}  // namespace vcd::baker
