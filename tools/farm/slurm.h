// Shards as array jobs of Slurm.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "plan.h"

namespace vcd {

struct SlurmOptions {
  std::vector<std::string> arguments;  // more for sbatch, such as --partition=…
  std::vector<std::string> bake;       // more for vc-bake, such as --cache=…
  unsigned threads = 1;                // processors that each shard asks for and uses
};

class Slurm {
 public:
  // Error (runtime): sbatch or squeue cannot be run here.
  static Result<Slurm> find(const FarmPlan& plan);

  // Submits array jobs of these shards, and notes their numbers in the plan's folder. Error (runtime) with sbatch's words.
  std::optional<Error> submit(const std::vector<unsigned>& shards, const SlurmOptions& options);
  // The shards that wait or run by what Slurm says. Error (runtime): it did not answer.
  Result<std::set<unsigned>> queued() const;

 private:
  explicit Slurm(const FarmPlan& plan) : plan_(&plan) {}
  std::optional<Error> submit_array(const std::vector<unsigned>& shards, unsigned offset, const SlurmOptions& options);
  const FarmPlan* plan_;
};

}  // namespace vcd
