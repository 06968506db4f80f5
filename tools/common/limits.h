// What this process may use of its machine: what there is, less what containers and batch jobs allow.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <filesystem>

namespace vcd::tools {

// Where the system says so. Others than the defaults are for tests.
struct Surroundings {
  std::filesystem::path root = "/";  // the folder of proc/ and sys/fs/cgroup/
  const char* (*variable)(const char* name) = [](const char* name) -> const char* { return std::getenv(name); };
  unsigned processors = 0;  // that the system lets this process run on; 0: asks it
};

// Bytes that are free or can be freed, on the machine (MemAvailable), in each control group that holds this process
// (version 2: memory.max, memory.high; version 1: memory.limit_in_bytes), and in the Slurm job (SLURM_MEM_PER_NODE, or
// SLURM_MEM_PER_CPU times its processors): the least of these. 0 if the system says nothing.
uint64_t available_memory(const Surroundings& surroundings = {});

// Processors that this process may run on, or as many as the control groups let it keep busy (version 2: cpu.max;
// version 1: cpu.cfs_quota_us), rounded up: the fewest. At least 1.
unsigned available_processors(const Surroundings& surroundings = {});

}  // namespace vcd::tools
