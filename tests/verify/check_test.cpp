#include <vcd/verify/check.h>

#include <gtest/gtest.h>

#include <sys/resource.h>

#include <vcd/baker/bake.h>
#include <vcd/writer/writer.h>

#include "support/meshes.h"

namespace vcd::verify {

using namespace baker;

namespace {

class CheckBytes : public ::testing::Test {
 protected:
  CheckBytes() {
    meshes_.push_back(*prepare(test::cube()));
    BakeOptions options;
    options.depth = 2;
    options.embed_geometry = true;
    const auto object = bake(meshes_[0], options);
    SidecarToWrite sidecar;
    sidecar.objects = {object->to_write()};
    bytes_ = std::move(*sidecar_bytes(sidecar));
    options_.audit.lines = 9000;
  }

  Outcome check(const std::vector<PreparedMesh>& meshes) {
    return check_bytes({bytes_.data.get(), bytes_.size}, meshes, options_);
  }

  std::vector<PreparedMesh> meshes_;
  AlignedBytes bytes_;
  CheckOptions options_;
};

long children() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  return usage.ru_minflt;
}

TEST_F(CheckBytes, AuditsTheMeshWithoutAnotherProcess) {
  const long before = children();
  const Outcome outcome = check(meshes_);
  EXPECT_EQ(outcome.exit_code(), 0);
  ASSERT_EQ(outcome.objects.size(), 1u);
  ASSERT_TRUE(outcome.objects[0].audit);
  EXPECT_EQ(outcome.objects[0].audit->sum(false).segments + outcome.objects[0].audit->sum(true).segments, 9000u);
  EXPECT_EQ(children(), before);
}

TEST_F(CheckBytes, IsStaleAgainstAnotherMesh) {
  EXPECT_TRUE(check({*prepare(test::sphere())}).has(IssueId::stale));
  EXPECT_TRUE(check({}).has(IssueId::stale));
}

TEST_F(CheckBytes, SaysWhatIsWrongWithTheBytes) {
  bytes_.data.get()[bytes_.size / 2] ^= std::byte{1};
  const Outcome outcome = check(meshes_);
  EXPECT_EQ(outcome.exit_code(), static_cast<int>(ErrorCode::invalid_file));
  EXPECT_TRUE(outcome.objects.empty());
}

TEST_F(CheckBytes, EndsAsNotVerifiedWhenStopped) {
  options_.stop = [] { return true; };
  EXPECT_TRUE(check(meshes_).has(IssueId::not_verified));
}

}  // namespace
}  // namespace vcd::verify
