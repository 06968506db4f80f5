// What is up to date is decided by kBakeRevision: it must be raised whenever a bake gives other bytes.
#include <gtest/gtest.h>

#include <cstdio>

#include <vcd/baker/source.h>

#include "support/files.h"
#include "support/meshes.h"

namespace vcd {
using namespace baker;
namespace {

std::string hash_of_bakes() {
  std::string bytes;
  const auto add = [&](const std::vector<std::byte>& file) {
    bytes.append(reinterpret_cast<const char*>(file.data()), file.size());
  };
  for (const Method method : {Method::sampled, Method::proven, Method::hybrid}) {
    BakeOptions options;
    options.method = method;
    options.depth = 3, options.horizons = true;
    options.samples = method == Method::sampled ? 16 : 0;
    const BakedObject solid = test::must_bake(test::cube(), options), open = test::must_bake(test::leaves(40), options),
                      round = test::must_bake(test::sphere(24, 48), options);
    add(test::sidecar_bytes({&solid, &open, &round}));
  }
  const BakedObject foliage = test::must_bake(test::leaves(3000), test::quick(1));  // a hierarchy of several levels
  add(test::sidecar_bytes({&foliage}));
  std::string digits;
  for (const uint8_t byte : content_hash(bytes)) {
    char two[3];
    std::snprintf(two, sizeof two, "%02x", byte);
    digits += two;
  }
  return digits;
}

TEST(Revision, OtherBytesAreAnotherRevision) {
  ASSERT_EQ(kBakeRevision, 11u) << "a new revision: put its number and hash here";
  EXPECT_EQ(hash_of_bakes(), "d09a3f390f6d9dabb0cc75e61fde2329")
      << "bakes give other bytes than revision 11: raise kBakeRevision";
}

}  // namespace
}  // namespace vcd
