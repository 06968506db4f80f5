// Horizons of a mesh, as the HORZ section holds them: <vcd/format/horizon.h>.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include <vcd/baker/hierarchy.h>
#include <vcd/baker/prepare.h>
#include <vcd/format/aligned_bytes.h>
#include <vcd/format/horizon.h>

namespace vcd::baker {

// Of directions above triangles from which something can be seen, those that are answered, by the triangles' areas. Of
// triangles that both sides see something from, both count, though one alone is answered.
struct HorizonShare {
  double uniform = 0, cosine = 0;  // all directions alike; by the cosine to the normal
};

// What is answered less often is not worth its bytes.
inline constexpr double kLeastHorizonShare = 0.2;  // of `cosine`

struct Horizons {
  AlignedBytes section;  // without data where the share is less than kLeastHorizonShare
  HorizonShare share;
};

// Whether a hierarchy is small enough for entries to name its triangles.
bool can_have_horizons(const HierarchyView& hierarchy);

// The horizons of a mesh with its hierarchy, proven: spec/proofs.md, "Horizons". The same geometry, in the same order
// of the source's triangles, gives the same bytes, whatever the number of threads. Nothing if it was stopped. Throws
// std::bad_alloc. For a number of threads, call it within with_threads().
//
// stop: asked often, from many threads at once; may be empty.
std::optional<Horizons> build_horizons(const PreparedMesh& mesh, const HierarchyView& hierarchy,
                                       const std::function<bool()>& stop = {});

// What build_horizons() would give and take, from some of the triangles.
struct HorizonForecast {
  HorizonShare share;
  uint64_t bytes = 0;  // 0: they would not be worth it
  double seconds = 0;  // on the threads at hand
};
std::optional<HorizonForecast> forecast_horizons(const PreparedMesh& mesh, const HierarchyView& hierarchy,
                                                 const std::function<bool()>& stop = {});

// What HorizonHeader::order_xxh3 says of a mesh.
uint64_t order_of(const PreparedMesh& mesh);

}  // namespace vcd::baker
