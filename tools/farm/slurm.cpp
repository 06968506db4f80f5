#include "slurm.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <map>
#include <sstream>

#include <span>

#include <vcd/baker/source.h>
#include <vcd/format/atomic_file.h>

#include "command.h"
#include "common/paths.h"
#include "this_program.h"

namespace vcd {
namespace {

namespace fs = std::filesystem;

// Slurm's MaxArraySize is 1001 unless an administrator changed it: larger plans are several arrays, each with an offset.
constexpr unsigned kArraySize = 1000;

// Jobs of this plan: number → offset of its array.
std::map<std::string, unsigned> jobs_of(const FarmPlan& plan) {
  std::map<std::string, unsigned> jobs;
  std::ifstream file(plan.folder / "slurm-jobs");
  std::string job;
  for (unsigned offset; file >> job >> offset;) jobs[job] = offset;
  return jobs;
}

}  // namespace

Result<Slurm> Slurm::find(const FarmPlan& plan) {
  for (const char* program : {"sbatch", "squeue"})
    if (const auto version = output_of({program, "--version"}); !version) return version.error();
  return Slurm(plan);
}

std::optional<Error> Slurm::submit(const std::vector<unsigned>& shards, const SlurmOptions& options) {
  std::map<unsigned, std::vector<unsigned>> arrays;
  for (const unsigned shard : shards) arrays[(shard - 1) / kArraySize * kArraySize].push_back(shard);
  for (const auto& [offset, numbers] : arrays)
    if (auto fault = submit_array(numbers, offset, options)) return fault;
  return std::nullopt;
}

std::optional<Error> Slurm::submit_array(const std::vector<unsigned>& shards, unsigned offset, const SlurmOptions& options) {
  std::string script = "#!/bin/sh\nexec " + shell_word(program_folder() / "vc-farm") + " run " + shell_word(plan_->folder) + " $((" + std::to_string(offset) +
                       " + SLURM_ARRAY_TASK_ID)) -j \"${SLURM_CPUS_PER_TASK:-1}\" ${SLURM_MEM_PER_NODE:+--memory-mb=$SLURM_MEM_PER_NODE}";
  for (const std::string& argument : options.bake) script += " " + shell_word(argument);
  script += "\n";
  const fs::path path = plan_->folder / ("slurm-" + std::to_string(offset) + ".sh");
  AtomicFile file(path);
  file.append(std::as_bytes(std::span(script)));
  if (const auto written = file.commit(); !written) return written.error();

  std::string tasks;
  for (const unsigned shard : shards) tasks += (tasks.empty() ? "" : ",") + std::to_string(shard - offset);
  std::vector<std::string> command = {"sbatch", "--parsable", "--requeue", "--job-name=vc-farm", "--array=" + tasks, "--chdir=" + plan_->folder.string(),
                                      "--output=" + (plan_->folder / "slurm-%A_%a.out").string(), "--open-mode=append",
                                      "--cpus-per-task=" + std::to_string(options.threads)};
  command.insert(command.end(), options.arguments.begin(), options.arguments.end());
  command.push_back(path.string());
  const auto answer = output_of(command);
  if (!answer) return answer.error();
  const std::string job = answer->substr(0, answer->find_first_of(";\n"));  // "123" or "123;cluster"
  std::ofstream jobs(plan_->folder / "slurm-jobs", std::ios::app);
  if (!(jobs << job << " " << offset << "\n").flush())
    return Error{ErrorCode::io, shown(plan_->folder / "slurm-jobs") + ": cannot be written; job " + job + " is submitted all the same"};
  return std::nullopt;
}

Result<std::set<unsigned>> Slurm::queued() const {
  const auto jobs = jobs_of(*plan_);
  // All jobs of this user: asked for single ones, squeue fails once the first is forgotten.
  const auto answer = output_of({"squeue", "--me", "--noheader", "--array", "--format=%F %K"});
  if (!answer) return answer.error();
  std::set<unsigned> shards;
  std::istringstream lines(*answer);
  std::string job, task;
  while (lines >> job >> task) {
    unsigned number = 0;
    const auto known = jobs.find(job);
    const bool is_number = std::from_chars(task.data(), task.data() + task.size(), number).ptr == task.data() + task.size();
    if (known != jobs.end() && is_number) shards.insert(known->second + number);
  }
  return shards;
}

}  // namespace vcd
