#include "geometry_hash.h"

#include <memory>

#include <xxhash.h>

namespace vcd::baker {

std::array<uint8_t, 16> geometry_hash(const PreparedMesh& mesh) {
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), XXH3_freeState);
  XXH3_128bits_reset(state.get());
  const uint64_t counts[2] = {mesh.positions.size(), mesh.triangles.size()};
  XXH3_128bits_update(state.get(), counts, sizeof counts);
  XXH3_128bits_update(state.get(), mesh.positions.data(), mesh.positions.size() * sizeof(Position));
  XXH3_128bits_update(state.get(), mesh.triangles.data(), mesh.triangles.size() * sizeof(TriangleIndices));
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(state.get()));
  return std::to_array(canonical.digest);
}

}  // namespace vcd::baker
