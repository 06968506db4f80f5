#include <vcd/runtime/sidecar.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include <embree3/rtcore.h>

#include <vcd/baker/audit.h>
#include <vcd/baker/tracer.h>
#include <vcd/format/contents.h>
#include <vcd/runtime/embree.h>
#include <vcd/runtime/vcd.h>

#include "support/count_allocations.h"
#include "support/files.h"
#include "support/meshes.h"

namespace vcd::test {
using namespace baker;
namespace {

class Runtime : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    SourceMesh second = leaves(30);
    second.name = "leaves";
    second.source_index = 4;
    const BakedObject a = must_bake(sphere(), quick(5, 81)), b = must_bake(second, quick(4));
    const auto raw = sidecar_bytes({&a, &b}), ship = sidecar_bytes({&a, &b}, Storage::zstd);
    write_file(*folder_ / "raw.vcd", raw);
    write_file(*folder_ / "ship.vcd", ship);
    mesh_ = new PreparedMesh(*prepare(sphere()));
    segments_ = new std::vector<Segment>(audit_segments(*mesh_, AuditKind::chords, 1, 20000));
    const auto inside = audit_segments(*mesh_, AuditKind::inside, 1, 5000);
    segments_->insert(segments_->end(), inside.begin(), inside.end());
  }
  static void TearDownTestSuite() {
    delete folder_;
    delete mesh_;
    delete segments_;
  }
  static std::vector<Visibility> answers(const Sidecar& sidecar) {
    std::vector<Visibility> result(segments_->size());
    sidecar.object(0).classify(*segments_, result);
    return result;
  }
  static std::string path(const char* name) { return (*folder_ / name).string(); }
  static inline TemporaryFolder* folder_;
  static inline PreparedMesh* mesh_;
  static inline std::vector<Segment>* segments_;
};

TEST_F(Runtime, AnswersAlikeMappedCopiedInflatedAndFromABuffer) {
  const auto mapped = Sidecar::open(path("raw.vcd"));
  const auto copied = Sidecar::open(path("raw.vcd"), {Load::copy, CheckLevel::bounds});
  const auto shipped = Sidecar::open(path("ship.vcd"));
  ASSERT_TRUE(mapped.ok() && copied.ok() && shipped.ok());
  const auto expected = answers(*mapped);
  EXPECT_EQ(answers(*copied), expected);
  EXPECT_EQ(answers(*shipped), expected);
  const auto bytes = read_file(path("raw.vcd"));
  for (size_t offset : {0, 8, 56}) {  // alignments: 64, or just 8
    const std::unique_ptr<std::byte, decltype(&std::free)> memory(
        static_cast<std::byte*>(std::aligned_alloc(64, (bytes.size() + 127) / 64 * 64)), std::free);
    std::copy(bytes.begin(), bytes.end(), memory.get() + offset);
    const auto buffered = Sidecar::open_buffer({memory.get() + offset, bytes.size()});
    ASSERT_TRUE(buffered.ok());
    EXPECT_EQ(answers(*buffered), expected);
  }
  EXPECT_EQ(Sidecar::open_buffer({bytes.data() + 1, bytes.size() - 1}).error().code, ErrorCode::usage);
}

TEST_F(Runtime, SingleAnswersEqualArrayAnswers) {
  const auto sidecar = Sidecar::open(path("raw.vcd"));
  const auto all = answers(*sidecar);
  int seen[3] = {};
  for (size_t i = 0; i < all.size(); ++i) {
    ASSERT_EQ(sidecar->object(0).classify((*segments_)[i]), all[i]);
    ++seen[static_cast<int>(all[i])];
  }
  EXPECT_GT(seen[0], 500);
  EXPECT_GT(seen[1], 500);
  EXPECT_GT(seen[2], 500);
}

TEST_F(Runtime, FindsObjectsByIndexNameAndHash) {
  const auto sidecar = Sidecar::open(path("raw.vcd"));
  ASSERT_EQ(sidecar->object_count(), 2u);
  EXPECT_EQ(sidecar->object(1).name(), "leaves");
  EXPECT_EQ(sidecar->find("leaves")->record().source_index, 4u);
  EXPECT_EQ(sidecar->find(mesh_->geometry_hash)->name(), "sphere");
  EXPECT_FALSE(sidecar->find("absent").has_value());
  EXPECT_FALSE(sidecar->find(std::array<uint8_t, 16>{}).has_value());
}

TEST_F(Runtime, SurvivesBeingMoved) {
  auto first = Sidecar::open(path("raw.vcd"));
  const Object object = first->object(0);
  const Sidecar second = std::move(*first);
  EXPECT_EQ(object.classify((*segments_)[0]), second.object(0).classify((*segments_)[0]));
}

TEST_F(Runtime, OccludedAsksTheFallbackForUnclassifiedOnly) {
  const auto sidecar = Sidecar::open(path("raw.vcd"));
  const Object object = sidecar->object(0);
  for (const Segment& s : *segments_) {
    int asked = 0;
    const bool yes = object.occluded(s, [&] { return ++asked, true; });
    const Visibility answer = object.classify(s);
    ASSERT_EQ(asked, answer == Visibility::unclassified);
    ASSERT_EQ(yes, answer != Visibility::clear);
  }
}

TEST_F(Runtime, QueriesDoNotAllocate) {
  const auto sidecar = Sidecar::open(path("raw.vcd"));
  const Object object = sidecar->object(0);
  std::vector<Visibility> out(segments_->size());
  const uint64_t before = allocation_count();
  object.classify(*segments_, out);
  for (const Segment& s : *segments_) out[0] = object.classify(s);
  EXPECT_EQ(allocation_count(), before);
}

TEST_F(Runtime, ManyThreadsMayAskAtOnce) {
  const auto sidecar = Sidecar::open(path("raw.vcd"));
  const auto expected = answers(*sidecar);
  std::vector<std::thread> threads;
  std::atomic<int> equal{0};
  for (int t = 0; t < 4; ++t) threads.emplace_back([&] { equal += answers(*sidecar) == expected; });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(equal, 4);
}

TEST_F(Runtime, ErrorsNameTheFileAndTheReason) {
  const auto missing = Sidecar::open(path("missing.vcd"));
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, ErrorCode::io);
  EXPECT_NE(missing.error().message.find("missing.vcd"), std::string::npos);
  EXPECT_EQ(Sidecar::open(folder_->path()).error().code, ErrorCode::io);
  write_file(path("empty.vcd"), {});
  for (Load load : {Load::map, Load::copy}) {
    const auto empty = Sidecar::open(path("empty.vcd"), {load, CheckLevel::checksums});
    ASSERT_FALSE(empty.ok());
    EXPECT_EQ(empty.error().code, ErrorCode::invalid_file);
    EXPECT_NE(empty.error().message.find("file-too-short"), std::string::npos);
  }
}

std::string golden(const std::string& name) { return (std::filesystem::path(VCD_GOLDEN_DIR) / name).string(); }

// Segments around the box, many of which pierce it.
std::vector<Segment> segments_around(const ObjectRecord& record, uint32_t count) {
  std::mt19937 random(count);
  std::uniform_real_distribution<float> around(-1, 2), inside(0, 1);
  std::vector<Segment> segments(count, Segment{{}, 0, {}, 1});
  for (Segment& s : segments)
    for (int a = 0; a < 3; ++a) {
      const float extent = record.box_max[a] - record.box_min[a], from = around(random);
      s.origin[a] = record.box_min[a] + extent * from;
      s.direction[a] = 2 * extent * (inside(random) - from);
    }
  return segments;
}

std::vector<Visibility> answers_of(const Object& object, std::span<const Segment> segments) {
  std::vector<Visibility> all(segments.size());
  object.classify(segments, all);
  for (size_t i = 0; i < all.size(); ++i) EXPECT_EQ(object.classify(segments[i]), all[i]);
  return all;
}

TEST(ProvenOnly, TakesStatisticalAnswersBack) {
  for (const char* name : {"depth1.vcd", "depth2.vcd", "depth4.vcd", "depth6.vcd", "depth7.vcd", "depth8.vcd"})
    for (CheckLevel check : {CheckLevel::checksums, CheckLevel::bounds}) {
      const auto all = Sidecar::open(golden(name), {Load::map, check, false});
      const auto proven = Sidecar::open(golden(name), {Load::map, check, true});
      ASSERT_TRUE(all.ok() && proven.ok());
      EXPECT_TRUE(all->object(0).answers() && proven->object(0).answers());
      const TreeView& tree = proven->contents().objects[0].tree;
      const ObjectRecord& record = all->object(0).record();
      const GridFrame frame = make_grid_frame(record.box_min, record.box_max);
      const auto segments = segments_around(record, 20000);
      const auto with = answers_of(all->object(0), segments), without = answers_of(proven->object(0), segments);
      int taken_back = 0, kept = 0;
      for (size_t i = 0; i < segments.size(); ++i) {
        if (with[i] != Visibility::blocked) {
          ASSERT_EQ(without[i], with[i]);
          continue;
        }
        const LineCell line = locate(frame, segments[i]);
        const bool proof = class_of(tree, line) == CellClass::blocked;
        ASSERT_EQ(without[i], proof ? Visibility::blocked : Visibility::unclassified);
        ++(proof ? kept : taken_back);
      }
      EXPECT_GT(kept, 1000) << name;
      EXPECT_EQ(taken_back > 100, record.method == static_cast<uint8_t>(Method::hybrid)) << name << " " << taken_back;
    }
}

TEST(ProvenOnly, ObjectsThatProveNothingAnswerNothing) {
  for (const char* name : {"methods.vcd", "depth5.vcd"})
    for (bool proven_only : {false, true}) {
      OpenOptions options;
      options.proven_only = proven_only;
      const auto sidecar = Sidecar::open(golden(name), options);
      ASSERT_TRUE(sidecar.ok());
      for (size_t i = 0; i < sidecar->object_count(); ++i) {
        const Object object = sidecar->object(i);
        const auto method = static_cast<Method>(object.record().method);
        const bool answers = method != Method::none && !(method == Method::sampled && proven_only);
        EXPECT_EQ(object.answers(), answers);
        const auto all = answers_of(object, segments_around(object.record(), 2000));
        EXPECT_EQ(std::count(all.begin(), all.end(), Visibility::unclassified) == 2000, !answers) << name << " " << i;
      }
    }
}

TEST(ProvenOnly, InC) {
  const auto whole = read_file(golden("methods.vcd"));
  const auto answers = [&](int proven_only, size_t index) {
    vcd_open_options options{};
    options.proven_only = proven_only;
    const vcd_sidecar *from_file = nullptr, *from_buffer = nullptr;
    EXPECT_EQ(vcd_open(golden("methods.vcd").c_str(), &options, &from_file, nullptr), VCD_SUCCESS);
    EXPECT_EQ(vcd_open_buffer(whole.data(), whole.size(), &options, &from_buffer, nullptr), VCD_SUCCESS);
    const int result = vcd_object_answers(vcd_object_at(from_file, index));
    EXPECT_EQ(vcd_object_answers(vcd_object_at(from_buffer, index)), result);
    vcd_close(from_file);
    vcd_close(from_buffer);
    return result;
  };
  EXPECT_EQ(answers(0, 0), 0);  // none
  EXPECT_EQ(answers(0, 2), 1);  // sampled
  EXPECT_EQ(answers(1, 2), 0);
  EXPECT_EQ(answers(1, 4), 1);  // proven
}

TEST_F(Runtime, TheBytesOfTheWriterAreUsedInPlace) {
  const BakedObject object = must_bake(sphere(), quick(3));
  SidecarToWrite out;
  out.objects.push_back(object.to_write());
  const auto bytes = vcd::sidecar_bytes(out);
  ASSERT_TRUE(bytes.ok());
  const auto sidecar = Sidecar::open_buffer(Bytes(bytes->data.get(), bytes->size));
  ASSERT_TRUE(sidecar.ok());
  const auto* top = reinterpret_cast<const std::byte*>(sidecar->contents().objects[0].tree.top);
  EXPECT_TRUE(top > bytes->data.get() && top < bytes->data.get() + bytes->size);
  EXPECT_FALSE(
      vcd::Sidecar::open_buffer(Bytes(bytes->data.get(), bytes->size), {Load::map, CheckLevel::checksums, true})
          ->object(0)
          .answers());
}

TEST_F(Runtime, TheCInterfaceSaysTheSame) {
  const vcd_sidecar* handle = nullptr;
  ASSERT_EQ(vcd_open(path("raw.vcd").c_str(), nullptr, &handle, nullptr), VCD_SUCCESS);
  ASSERT_EQ(vcd_object_count(handle), 2u);
  const vcd_object* object = vcd_object_at(handle, 0);
  EXPECT_EQ(vcd_object_at(handle, 2), nullptr);
  EXPECT_EQ(vcd_object_by_name(handle, "sphere"), object);
  EXPECT_EQ(vcd_object_by_name(handle, "absent"), nullptr);
  EXPECT_EQ(vcd_object_by_hash(handle, mesh_->geometry_hash.data()), object);
  size_t length = 0;
  const char* name = vcd_object_name(object, &length);
  EXPECT_EQ(std::string(name, length), "sphere");

  const auto expected = answers(*Sidecar::open(path("raw.vcd")));
  std::vector<vcd_segment> segments(segments_->size());
  std::memcpy(segments.data(), segments_->data(), segments.size() * sizeof(vcd_segment));
  std::vector<uint8_t> out(segments.size());
  vcd_classify_array(object, segments.data(), segments.size(), out.data());
  for (size_t i = 0; i < out.size(); ++i) {
    ASSERT_EQ(out[i], static_cast<uint8_t>(expected[i]));
    ASSERT_EQ(vcd_classify(object, &segments[i]), out[i]);
  }
  vcd_close(handle);

  vcd_error error{sizeof(vcd_error), ""};
  EXPECT_EQ(vcd_open(path("missing.vcd").c_str(), nullptr, &handle, &error), VCD_ERROR_IO);
  EXPECT_EQ(handle, nullptr);
  EXPECT_NE(std::string(error.message).find("missing.vcd"), std::string::npos);
  EXPECT_EQ(vcd_open(nullptr, nullptr, &handle, &error), VCD_ERROR_USAGE);
  vcd_close(nullptr);
  EXPECT_STREQ(vcd_result_string(VCD_ERROR_INVALID_FILE), "invalid file");
}

TEST_F(Runtime, TheEmbreeAdapterGivesTheTracersAnswer) {
  const auto sidecar = Sidecar::open(path("raw.vcd"));
  const Object object = sidecar->object(0);
  const auto tracer = Tracer::build(mesh_->positions, mesh_->triangles);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  uint64_t wrong = 0, traced = 0;
  for (const Segment& s : *segments_) {
    RTCRay ray{};
    ray.org_x = s.origin[0], ray.org_y = s.origin[1], ray.org_z = s.origin[2], ray.tnear = s.t_min;
    ray.dir_x = s.direction[0], ray.dir_y = s.direction[1], ray.dir_z = s.direction[2], ray.tfar = s.t_max;
    ray.mask = 0xFFFFFFFF;
    const bool was_traced = occluded1(object, tracer->scene(), &context, &ray);
    ASSERT_EQ(was_traced, object.classify(s) == Visibility::unclassified);
    traced += was_traced;
    wrong += (ray.tfar < 0) != tracer->occluded(s);
    if (was_traced) {
      ASSERT_EQ(ray.tfar < 0, tracer->occluded(s));
    }
  }
  EXPECT_GT(traced, 0u);
  EXPECT_LT(wrong, segments_->size() / 200);
}

}  // namespace
}  // namespace vcd::test
