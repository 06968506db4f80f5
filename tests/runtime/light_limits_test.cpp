// Bundles of lights that are degenerate: lines, points, as good as parallel edges, seen from their own plane or corner,
// spheres of no radius or around the origin, and of every scale. Against exact arithmetic.
#include <vcd/runtime/bundle.h>

#include <cmath>

#include <gtest/gtest.h>

#include "beam/beam.h"
#include "fuzz/odd_places.h"
#include "support/exact_world.h"
#include "support/files.h"
#include "support/meshes.h"
#include "support/random.h"

namespace vcd::test {
namespace {

// The cube [-1, 1]^3.
class LightLimits : public testing::Test {
 protected:
  static baker::SourceMesh wide_cube() {
    baker::SourceMesh mesh = cube();
    for (auto& p : mesh.positions)
      for (float& x : p) x = 2 * x - 1;
    return mesh;
  }

  struct Counts {
    uint64_t answered[2] = {};  // clear, blocked
    uint64_t wrong = 0;
  };
  template <class Bundle, class Matters>
  void ask(const Bundle& bundle, Counts& counts, const Matters& matters) const {
    for (const Sidecar& sidecar : sidecars_) {
      std::vector<uint64_t> blocked((bundle.size() + 63) / 64), left(blocked);
      sidecar.object(0).classify(bundle, blocked, left);
      for (size_t i = 0; i < bundle.size(); ++i) {
        if ((left[i / 64] >> (i % 64) & 1) || !matters(i)) continue;
        const bool is_blocked = blocked[i / 64] >> (i % 64) & 1;
        ++counts.answered[is_blocked];
        counts.wrong += is_blocked != exact_.meets(segment_of(bundle, i));
      }
    }
  }

  baker::SourceMesh mesh_ = wide_cube();
  baker::BakedObject baked_ = must_bake(mesh_, proven(kSanitized ? 3 : 4));
  std::vector<std::byte> bytes_ = sidecar_bytes({&baked_});
  std::vector<Sidecar> sidecars_ = [&] {
    std::vector<Sidecar> all;
    for (const std::string& kernel : kernels())
      all.push_back(std::move(*Sidecar::open_buffer(bytes_, {.kernel = kernel})));
    return all;
  }();
  ExactInstance exact_{mesh_, kStill};
};

constexpr auto kAll = [](size_t) { return true; };

// Of two corner lines that are as good as parallel, rounding makes any normal.
TEST_F(LightLimits, AThinLightIsNoPlane) {
  const std::vector<float> ends = {0, 1}, crossed = {1, 0};
  Counts counts;
  for (float width = 1e-10f; width > 1e-16f; width *= 0.99f)
    for (const auto* v : {&ends, &crossed}) {
      const QuadBundle bundle{
          {4.1f, 3.1f, -3.2f}, {-5.6f, -3.9f, 6.8f}, {-width, -0.7f * width, width}, {6.7f, -9.6f, -1.3f}, ends, *v};
      ask(bundle, counts, kAll);
    }
  EXPECT_EQ(counts.wrong, 0u);
  EXPECT_GT(counts.answered[0] + counts.answered[1], 50u);
}

// A line of light is decided as a whole like others: it is clear where the box lies beside its plane.
TEST_F(LightLimits, ALineOfLightIsClearBesideTheBox) {
  const std::vector<float> u = {0, 0.5f, 1, 0.3f}, v = {0, 1, 0.2f, 0.7f};
  for (const Sidecar& sidecar : sidecars_) {
    const QuadBundle line{{0, 3, -2}, {-3, 1.5f, 9}, {6, 0, 0}, {0, 0, 0}, u, v},
        point{{0, 3, -2}, {0, 2, 9}, {}, {}, u, v};
    for (const QuadBundle& bundle : {line, point}) {
      uint64_t blocked = 0, left = 0;
      sidecar.object(0).classify(bundle, std::span(&blocked, 1), std::span(&left, 1));
      EXPECT_EQ(blocked | left, 0u) << sidecar.kernel();
    }
  }
}

// The bound of spec/proofs.md, "Bundles": what u and v say of a sphere's directions is off by 3 rounding 2^-24 size.
TEST(SphereBeam, DirectionsAreRoundedAsDerived) {
  using Number = long double;
  FloatRandom random(31);
  Number worst = 0;
  for (int i = 0; i < (kSanitized ? 20000 : 200000); ++i) {
    SphereBundle bundle{};
    // From everywhere, also from close to an axis, and of every radius up to where no frame is usable.
    for (float& x : bundle.centre)
      x = random.between(-1, 1) * (random.below(3) ? 1 : std::exp2(random.between(-30, 0)));
    const float distance = std::hypot(bundle.centre[0], bundle.centre[1], bundle.centre[2]);
    bundle.radius = distance * (random.below(2) ? random.uniform() : std::exp2(random.between(-30, 0)));
    float sample[3], out[3];
    for (float& x : out) x = random.between(-1, 1);
    for (size_t a = 0; a < 3; ++a)
      sample[a] = bundle.centre[a] + 0.99f * bundle.radius * out[a] / std::hypot(out[0], out[1], out[2]);
    bundle.x = {&sample[0], 1}, bundle.y = {&sample[1], 1}, bundle.z = {&sample[2], 1};
    const BeamFrame frame = beam_frame(bundle);
    if (!frame.usable) continue;
    BundleChunk chunk;
    chunk.first = 0, chunk.count = 1, chunk.u_extent = chunk.v_extent = {0, 1};
    place(bundle, frame, chunk);
    set_size(frame, chunk);
    // The direction is sample itself; both points in one plane across the axis.
    Number said[3], along_said = 0, along = 0;
    for (size_t a = 0; a < 3; ++a) {
      said[a] = Number{frame.corner[a]} + Number{chunk.u[0]} * Number{frame.edge_u[a]} +
                Number{chunk.v[0]} * Number{frame.edge_v[a]};
      along_said += said[a] * Number{bundle.centre[a]}, along += Number{sample[a]} * Number{bundle.centre[a]};
    }
    for (size_t a = 0; a < 3; ++a)
      worst = std::max(worst, std::abs(said[a] - along_said / along * Number{sample[a]}) /
                                  (3 * Number{frame.rounding} * 0x1p-24L * Number{chunk.size[a]}));
  }
  EXPECT_LT(worst, 1);
  EXPECT_GT(worst, 0.2L);  // or the bound is of something else
}

TEST_F(LightLimits, NoDegenerateLightIsAnsweredWrongly) {
  Counts quads, spheres;
  for (uint32_t seed = 0; seed < (kSanitized ? 300u : 5000u); ++seed) {
    uint8_t bytes[4];
    std::memcpy(bytes, &seed, sizeof bytes);
    fuzz::OddPlaces places(bytes);
    const fuzz::OddLights lights(places, {{{2, 0, 0, -1}, {0, 2, 0, -1}, {0, 0, 2, -1}}});
    ask(lights.quad, quads, kAll);
    ask(lights.sphere, spheres, [&](size_t i) { return lights.is_inside(i); });
  }
  for (const Counts& counts : {quads, spheres}) {
    EXPECT_EQ(counts.wrong, 0u);
    for (const uint64_t n : counts.answered) EXPECT_GT(n, kSanitized ? 50u : 1000u);
  }
}

}  // namespace
}  // namespace vcd::test
