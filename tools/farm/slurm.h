// Shards as array jobs of Slurm.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "plan.h"

namespace vcd::farm {

struct SlurmOptions {
  std::vector<std::string> arguments;  // more for sbatch, such as --partition=…
  std::vector<std::string> bake;       // more for vc-bake, such as --cache=…
  unsigned threads = 1;                // processors that each shard asks for and uses
};

class Slurm {
 public:
  // Error (runtime): sbatch or squeue cannot be run here.
  static Result<Slurm> find(const FarmPlan& plan);

  // Submits array jobs of these shards. Their name says which plan they are of. Error (runtime) with sbatch's words.
  std::optional<Error> submit(const std::vector<unsigned>& shards, const SlurmOptions& options);

  struct Queue {
    std::set<unsigned> shards;  // that wait or run by what Slurm says
    std::set<unsigned> held;    // of them, those that it will not start by itself
  };
  Result<Queue> queue() const;  // Error (runtime): it did not answer, so nothing is known

 private:
  explicit Slurm(const FarmPlan& plan) : plan_(&plan) {}
  std::optional<Error> submit_array(const std::vector<unsigned>& shards, unsigned offset, const SlurmOptions& options);
  std::string job_name() const;

  const FarmPlan* plan_;
};

}  // namespace vcd::farm
