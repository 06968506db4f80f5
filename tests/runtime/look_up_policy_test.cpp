#include <vcd/runtime/look_up_policy.h>

#include <gtest/gtest.h>

namespace vcd::test {
namespace {

using Use = LookUpPolicy::Use;

// Batches of one kind until it is decided, each of what its way costs; how many there were.
int decide(LookUpPolicy& policy, From from, double traced, double looked_up, double interrupted = 0) {
  int batches = 0;
  while (policy.undecided(from) && batches < 1000) {
    const bool look_up = policy.look_up(from);
    // Now and then the system is busy with something else.
    policy.took(from, look_up, 128 * (look_up ? looked_up : traced) + (batches % 64 == 32 ? interrupted : 0), 128);
    ++batches;
  }
  return batches;
}

TEST(LookUpPolicy, TakesTheCheaperWayForEachKind) {
  LookUpPolicy policy;
  EXPECT_LT(decide(policy, From::outside, 40, 12), 200);
  EXPECT_TRUE(policy.look_up(From::outside));
  EXPECT_TRUE(policy.undecided(From::inside));
  decide(policy, From::inside, 40, 44);
  EXPECT_FALSE(policy.look_up(From::inside));
  EXPECT_TRUE(policy.look_up(From::outside));
  policy.fix(From::inside, Use::measured);
  decide(policy, From::inside, 40, 39.5);  // not worth while
  EXPECT_FALSE(policy.look_up(From::inside));
  EXPECT_FALSE(policy.undecided(From::self));
  EXPECT_FALSE(policy.look_up(From::self));
}

TEST(LookUpPolicy, TriesBothWaysInTurn) {
  LookUpPolicy policy;
  int looked_up = 0;
  for (int i = 0; i < 64; ++i) {
    const bool look_up = policy.look_up(From::outside);
    EXPECT_EQ(look_up, policy.look_up(From::outside));
    looked_up += look_up;
    policy.took(From::outside, look_up, 100, 10);
  }
  EXPECT_EQ(looked_up, 32);
}

TEST(LookUpPolicy, IsNotDecidedByInterruptions) {
  LookUpPolicy policy;
  decide(policy, From::outside, 40, 30, 1e9);
  EXPECT_TRUE(policy.look_up(From::outside));
}

TEST(LookUpPolicy, DoesAsTheRendererSays) {
  LookUpPolicy policy(Use::always, Use::never, Use::measured);
  EXPECT_TRUE(policy.look_up(From::outside));
  EXPECT_FALSE(policy.look_up(From::inside));
  policy.took(From::outside, true, 1e9, 1);
  EXPECT_TRUE(policy.look_up(From::outside));
  EXPECT_TRUE(policy.undecided(From::self));
  policy.fix(From::self, Use::always);
  EXPECT_FALSE(policy.undecided(From::self));
  EXPECT_TRUE(policy.look_up(From::self));
  policy.fix(From::outside, Use::measured);
  EXPECT_TRUE(policy.undecided(From::outside));
}

}  // namespace
}  // namespace vcd::test
