// Every kernel for arrays against single calls, on segments of every kind and on trees of every layout.
#include <vcd/runtime/sidecar.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include <vcd/baker/audit.h>
#include <vcd/baker/measure.h>
#include <vcd/runtime/vcd.h>

#include "support/count_allocations.h"
#include "support/files.h"
#include "support/meshes.h"
#include "support/special_floats.h"

namespace vcd::test {
using namespace baker;
namespace {

// Lines of all kinds through and about a box: random ones, along axes, through corners and edges, in faces, from far
// away and from inside, with ends on the box, and with every float that could do harm.
std::vector<Segment> segments_about(const ObjectRecord& record, size_t count) {
  std::mt19937_64 random(7);
  const auto below = [&](uint32_t n) { return static_cast<uint32_t>(random() % n); };
  const auto uniform = [&] { return static_cast<float>(random() >> 40) * 0x1p-24f; };
  constexpr float kOdd[] = {0.0f,  -0.0f,  1e-45f,    -1e-38f,    1e-30f,
                            1e30f, -3e38f, kInfinity, -kInfinity, std::numeric_limits<float>::quiet_NaN(),
                            1.0f};
  std::vector<Segment> segments;
  while (segments.size() < count) {
    Segment s{};
    const uint32_t kind = below(8);
    for (int a = 0; a < 3; ++a) {
      const float low = record.box_min[a], size = record.box_max[a] - record.box_min[a];
      const auto place = [&](float spread) {
        return below(4) == 0 ? (below(2) ? low : record.box_max[a]) : low + size * (0.5f + spread * (uniform() - 0.5f));
      };
      const float far = kind == 6 ? std::exp2(static_cast<float>(below(16))) : 1.0f;
      s.origin[a] = place((kind == 1 ? 1.0f : 3.0f) * far);
      s.direction[a] = (below(6) == 0 ? s.origin[a] : place(1.5f)) - s.origin[a];
    }
    s.t_min = 0.0f;
    s.t_max = kind == 2 ? uniform() : kind == 3 ? kInfinity : 1.0f + 3 * uniform();
    if (kind == 4) s.t_min = uniform() - 0.5f;
    if (kind == 5)
      for (int a = 0; a < 3; ++a)
        if (below(2)) s.direction[a] = below(2) ? 0.0f : -0.0f;
    if (kind == 7) {
      float values[8];
      std::memcpy(values, &s, sizeof s);
      for (float& value : values)
        if (below(3) == 0)
          value = below(2) ? kOdd[below(std::size(kOdd))] : std::bit_cast<float>(static_cast<uint32_t>(random()));
      std::memcpy(&s, values, sizeof s);
    }
    segments.push_back(s);
  }
  return segments;
}

// The same as structure of arrays, each at an odd address.
class Arrays {
 public:
  explicit Arrays(std::span<const Segment> segments) : count_(segments.size()) {
    for (size_t k = 0; k < 8; ++k) {
      values_[k].resize(count_ + 1);
      for (size_t i = 0; i < count_; ++i) {
        float all[8];
        std::memcpy(all, &segments[i], sizeof all);
        values_[k][i + 1] = all[k];
      }
    }
  }
  SegmentArrays view() const {
    const auto at = [&](size_t k) { return values_[k].data() + 1; };
    return {{at(0), at(1), at(2)}, at(3), {at(4), at(5), at(6)}, at(7), count_};
  }

 private:
  size_t count_;
  std::vector<float> values_[8];
};

// The first difference between single calls and a kernel, or count.
size_t first_difference(const Object& object, std::span<const Segment> segments, std::span<const Visibility> answers) {
  for (size_t i = 0; i < segments.size(); ++i)
    if (object.classify(segments[i]) != answers[i]) return i;
  return segments.size();
}

void expect_all_kernels_alike(Bytes bytes, const std::string& what, bool all_answers = true) {
  std::array<size_t, 3> seen{};
  for (const bool proven_only : {false, true})
    for (const std::string& kernel : kernels()) {
      OpenOptions options;
      options.proven_only = proven_only;
      options.kernel = kernel;
      const auto sidecar = Sidecar::open_buffer(bytes, options);
      ASSERT_TRUE(sidecar.ok()) << sidecar.error().message;
      EXPECT_EQ(sidecar->kernel(), kernel);
      for (size_t o = 0; o < sidecar->object_count(); ++o) {
        const Object object = sidecar->object(o);
        const auto segments = segments_about(object.record(), 20011);
        std::vector<Visibility> answers(segments.size());
        object.classify(segments, answers);
        ASSERT_EQ(first_difference(object, segments, answers), segments.size())
            << what << ", object " << o << ", " << kernel;
        std::fill(answers.begin(), answers.end(), Visibility{9});
        object.classify(Arrays(segments).view(), answers);
        ASSERT_EQ(first_difference(object, segments, answers), segments.size())
            << what << ", object " << o << ", " << kernel << ", arrays";
        for (Visibility answer : answers) ++seen[static_cast<size_t>(answer)];
      }
    }
  for (size_t n : seen) EXPECT_TRUE(!all_answers || n > 100u) << what;
}

TEST(Kernels, AreListedFastestFirst) {
  const auto names = kernels();
  ASSERT_GE(names.size(), 2u);
  EXPECT_EQ(names.back(), "scalar");
  const auto file = read_file(std::filesystem::path(VCD_GOLDEN_DIR) / "depth2.vcd");
  EXPECT_EQ(Sidecar::open_buffer(file)->kernel(), names.front());
  OpenOptions options;
  options.kernel = "abacus";
  const auto refused = Sidecar::open_buffer(file, options);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::usage);
  EXPECT_NE(refused.error().message.find("abacus"), std::string::npos);
}

TEST(Kernels, EqualSingleCallsOnTreesOfEveryDepth) {
  for (uint32_t depth = 1; depth <= 8; ++depth) {
    const std::string name = "depth" + std::to_string(depth) + ".vcd";
    expect_all_kernels_alike(read_file(std::filesystem::path(VCD_GOLDEN_DIR) / name), name);
  }
}

TEST(Kernels, EqualSingleCallsOnBakedMeshes) {
  SourceMesh long_box = sphere();
  for (Position& p : long_box.positions) p[0] *= 1e6f, p[2] -= 1e4f;
  const BakedObject objects[] = {must_bake(sphere(), quick(5, 81)), must_bake(leaves(30), quick(4)),
                                 must_bake(long_box, quick(3))};
  for (const BakedObject& object : objects)
    expect_all_kernels_alike(sidecar_bytes({&object}), object.name, &object == objects);
  // Nothing clear, nothing blocked: what has no answer is not looked for.
  const BakedObject unclassified = make_unclassified_object(*prepare(sphere()), 3);
  expect_all_kernels_alike(sidecar_bytes({&unclassified}), "unclassified", false);
  BakeOptions none = quick(3);
  none.method = Method::none;
  const BakedObject nothing = must_bake(sphere(), none);
  expect_all_kernels_alike(sidecar_bytes({&nothing}), "none", false);
}

TEST(Kernels, TakeAnyCountAndAlignmentAndWriteNothingElse) {
  const BakedObject baked = must_bake(sphere(), quick(4));
  const auto bytes = sidecar_bytes({&baked});
  for (const std::string& kernel : kernels()) {
    OpenOptions options;
    options.kernel = kernel;
    const auto sidecar = Sidecar::open_buffer(bytes, options);
    const Object object = sidecar->object(0);
    const auto segments = segments_about(object.record(), 300);
    for (size_t count = 0; count < 150; ++count) {
      const auto some = std::span(segments).subspan(count % 7, count);
      std::vector<Visibility> answers(count + 1, Visibility{9});
      object.classify(some, std::span(answers).first(count));
      EXPECT_EQ(first_difference(object, some, std::span(answers).first(count)), count) << kernel;
      EXPECT_EQ(answers[count], Visibility{9}) << kernel << ", " << count;
      std::fill(answers.begin(), answers.end(), Visibility{9});
      object.classify(Arrays(some).view(), std::span(answers).first(count));
      EXPECT_EQ(first_difference(object, some, std::span(answers).first(count)), count) << kernel;
      EXPECT_EQ(answers[count], Visibility{9}) << kernel << ", " << count;
    }
  }
}

TEST(Kernels, DoNotAllocate) {
  const BakedObject baked = must_bake(sphere(), quick(4));
  const auto bytes = sidecar_bytes({&baked});
  const auto sidecar = Sidecar::open_buffer(bytes);
  const auto segments = segments_about(sidecar->object(0).record(), 1001);
  const Arrays arrays(segments);
  std::vector<Visibility> answers(segments.size());
  const uint64_t before = allocation_count();
  sidecar->object(0).classify(segments, answers);
  sidecar->object(0).classify(arrays.view(), answers);
  EXPECT_EQ(allocation_count(), before);
}

TEST(Kernels, InC) {
  const BakedObject baked = must_bake(sphere(), quick(4));
  const auto bytes = sidecar_bytes({&baked});
  size_t count = 0;
  while (vcd_kernel(count)) ++count;
  EXPECT_EQ(count, kernels().size());
  for (size_t k = 0; k < count; ++k) {
    vcd_open_options options{};
    options.kernel = vcd_kernel(k);
    const vcd_sidecar* sidecar = nullptr;
    ASSERT_EQ(vcd_open_buffer(bytes.data(), bytes.size(), &options, &sidecar, nullptr), VCD_SUCCESS);
    const vcd_object* object = vcd_object_at(sidecar, 0);
    const auto segments = segments_about(baked.record, 1001);
    std::vector<vcd_segment> in_c(segments.size());
    std::memcpy(in_c.data(), segments.data(), segments.size() * sizeof(Segment));
    std::vector<uint8_t> answers(segments.size()), again(segments.size());
    vcd_classify_array(object, in_c.data(), in_c.size(), answers.data());
    const Arrays arrays(segments);
    const SegmentArrays a = arrays.view();
    const vcd_segment_arrays view = {{a.origin[0], a.origin[1], a.origin[2]},
                                     a.t_min,
                                     {a.direction[0], a.direction[1], a.direction[2]},
                                     a.t_max,
                                     a.count};
    vcd_classify_arrays(object, &view, again.data());
    for (size_t i = 0; i < segments.size(); ++i) {
      ASSERT_EQ(answers[i], vcd_classify(object, &in_c[i]));
      ASSERT_EQ(again[i], answers[i]);
    }
    vcd_close(sidecar);
  }
  vcd_open_options options{};
  options.size = sizeof options;
  options.kernel = "abacus";
  const vcd_sidecar* sidecar = nullptr;
  vcd_error error{};
  error.size = sizeof error;
  EXPECT_EQ(vcd_open_buffer(bytes.data(), bytes.size(), &options, &sidecar, &error), VCD_ERROR_USAGE);
  EXPECT_NE(std::string(error.message).find("abacus"), std::string::npos);
}

}  // namespace
}  // namespace vcd::test
