// Limits of containers and batch jobs, read out of folders that stand for / of such machines.
#include "common/limits.h"

#include <fstream>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "support/files.h"

namespace vcd::test {
namespace {

using tools::available_memory;
using tools::available_processors;

constexpr uint64_t kMiB = 1 << 20;
std::map<std::string, std::string> variables;

class Limits : public ::testing::Test {
 protected:
  Limits() {
    variables.clear();
    write("proc/meminfo", "MemTotal:  16000000 kB\nMemFree:  100 kB\nMemAvailable:   8192000 kB\n");
    around_.root = folder_ / "";
    around_.variable = [](const char* name) -> const char* {
      const auto found = variables.find(name);
      return found == variables.end() ? nullptr : found->second.c_str();
    };
    around_.processors = 8;
  }
  void write(const std::string& path, const std::string& text) {
    std::filesystem::create_directories((folder_ / path).parent_path());
    std::ofstream(folder_ / path) << text;
  }
  uint64_t mebibytes() const { return available_memory(around_) / kMiB; }
  unsigned processors() const { return available_processors(around_); }

  TemporaryFolder folder_;
  tools::Surroundings around_;
};

TEST_F(Limits, WithoutAnyTheMachineIsAllThereIs) {
  EXPECT_EQ(mebibytes(), 8000u);
  EXPECT_EQ(processors(), 8u);
  write("proc/self/cgroup", "0::/user.slice\n");  // of which nothing is to be seen
  EXPECT_EQ(mebibytes(), 8000u);
  std::filesystem::remove(folder_ / "proc/meminfo");
  EXPECT_EQ(available_memory(around_), 0u);
}

TEST_F(Limits, Version2CountsInEveryGroupAbove) {
  write("proc/self/cgroup", "0::/a/b/c\n");
  write("sys/fs/cgroup/a/b/c/memory.max", "max\n");
  write("sys/fs/cgroup/a/b/c/memory.high", "max\n");
  write("sys/fs/cgroup/a/b/c/cpu.max", "max 100000\n");
  EXPECT_EQ(mebibytes(), 8000u);
  EXPECT_EQ(processors(), 8u);
  write("sys/fs/cgroup/a/b/memory.high", "3145728000\n");
  EXPECT_EQ(mebibytes(), 3000u);
  write("sys/fs/cgroup/a/memory.max", "2097152000\n");
  EXPECT_EQ(mebibytes(), 2000u);
  write("sys/fs/cgroup/a/memory.current", "1048576000\n");
  EXPECT_EQ(mebibytes(), 1000u);
  write("sys/fs/cgroup/a/memory.stat", "anon 5\nfile 9\ninactive_file 524288000\n");
  EXPECT_EQ(mebibytes(), 1500u);
  write("sys/fs/cgroup/a/memory.current", "4097152000\n");  // all of it, and more
  EXPECT_EQ(available_memory(around_), 1u);                 // 0 would say that nobody knows
  write("sys/fs/cgroup/a/cpu.max", "350000 100000\n");
  EXPECT_EQ(processors(), 4u);
  write("sys/fs/cgroup/a/b/cpu.max", "5000 100000\n");
  EXPECT_EQ(processors(), 1u);
}

TEST_F(Limits, InAContainerTheGroupIsTheRootOfWhatIsSeen) {
  write("proc/self/cgroup", "0::/\n");
  write("sys/fs/cgroup/memory.max", "536870912\n");
  write("sys/fs/cgroup/cpu.max", "200000 100000\n");
  EXPECT_EQ(mebibytes(), 512u);
  EXPECT_EQ(processors(), 2u);
  for (const char* elsewhere : {"0::/../other\n", "0::/docker/0123\n"}) {
    write("proc/self/cgroup", elsewhere);
    EXPECT_EQ(mebibytes(), 512u) << elsewhere;
  }
}

TEST_F(Limits, Version1HasAHierarchyForEachController) {
  write("proc/self/cgroup", "9:name=systemd:/x\n5:cpu,cpuacct:/slurm/job\n4:memory:/slurm/job\n");
  write("sys/fs/cgroup/memory/slurm/job/memory.limit_in_bytes", "9223372036854771712\n");
  write("sys/fs/cgroup/cpu,cpuacct/slurm/job/cpu.cfs_quota_us", "-1\n");
  write("sys/fs/cgroup/cpu,cpuacct/slurm/job/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(mebibytes(), 8000u);
  EXPECT_EQ(processors(), 8u);
  write("sys/fs/cgroup/memory/slurm/memory.limit_in_bytes", "1048576000\n");
  write("sys/fs/cgroup/cpu,cpuacct/slurm/cpu.cfs_quota_us", "250000\n");
  write("sys/fs/cgroup/cpu,cpuacct/slurm/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(mebibytes(), 1000u);
  EXPECT_EQ(processors(), 3u);
  write("sys/fs/cgroup/memory/slurm/memory.usage_in_bytes", "524288000\n");
  write("sys/fs/cgroup/memory/slurm/memory.stat", "cache 1\ntotal_inactive_file 104857600\n");
  EXPECT_EQ(mebibytes(), 600u);
  // A group above that is not to be seen.
  write("sys/fs/cgroup/memory/slurm/job/memory.stat", "hierarchical_memory_limit 314572800\n");
  EXPECT_EQ(mebibytes(), 300u);
}

TEST_F(Limits, MountsSayWhereGroupsAre) {
  write("proc/self/mountinfo",
        "31 23 0:28 / /sys/fs/cgroup rw - tmpfs tmpfs rw,mode=755\n"
        "32 31 0:29 /docker/0123 /groups/mem rw,relatime shared:9 - cgroup cgroup rw,memory\n"
        "33 31 0:30 /docker/0123 /groups/cpu rw - cgroup cgroup rw,cpu,cpuacct\n"
        "34 31 0:31 / /groups/unified rw - cgroup2 cgroup2 rw\n");
  write("proc/self/cgroup", "4:memory:/docker/0123/inner\n1:cpu,cpuacct:/docker/0123\n0::/here\n");
  write("groups/mem/memory.limit_in_bytes", "1048576000\n");
  write("groups/cpu/cpu.cfs_quota_us", "300000\n");
  write("groups/cpu/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(mebibytes(), 1000u);
  EXPECT_EQ(processors(), 3u);
  write("groups/mem/inner/memory.limit_in_bytes", "524288000\n");
  EXPECT_EQ(mebibytes(), 500u);
  write("groups/unified/here/memory.max", "262144000\n");
  write("groups/unified/here/cpu.max", "100000 100000\n");
  EXPECT_EQ(mebibytes(), 250u);
  EXPECT_EQ(processors(), 1u);
}

TEST_F(Limits, SlurmSaysWhatAJobMayTake) {
  variables = {{"SLURM_MEM_PER_NODE", "2000"}};
  EXPECT_EQ(mebibytes(), 2000u);
  variables = {{"SLURM_MEM_PER_NODE", "0"}};
  EXPECT_EQ(mebibytes(), 8000u);
  variables = {{"SLURM_MEM_PER_CPU", "300"}, {"SLURM_CPUS_ON_NODE", "4"}};
  EXPECT_EQ(mebibytes(), 1200u);
  variables["SLURM_CPUS_PER_TASK"] = "2";
  EXPECT_EQ(mebibytes(), 600u);
  variables = {{"SLURM_MEM_PER_CPU", "300"}};
  EXPECT_EQ(mebibytes(), 300u);
  for (const char* odd : {"", "many", "-3", "99999999999999999999", "18446744073709551615"}) {
    variables = {{"SLURM_MEM_PER_CPU", odd}, {"SLURM_CPUS_ON_NODE", "4"}};
    EXPECT_EQ(mebibytes(), 8000u) << odd;
  }
}

TEST_F(Limits, WhatMakesNoSenseLimitsNothing) {
  write("proc/self/cgroup", "nonsense\n0\n:::\n0::relative\n");
  write("sys/fs/cgroup/memory.max", "lots\n");
  write("sys/fs/cgroup/cpu.max", "100000 0\n");
  EXPECT_EQ(mebibytes(), 8000u);
  EXPECT_EQ(processors(), 8u);
}

TEST(LimitsHere, AreSome) {
  EXPECT_GT(available_memory(), 0u);
  EXPECT_GE(available_processors(), 1u);
}

}  // namespace
}  // namespace vcd::test
