#include "slurm.h"

#include <charconv>
#include <map>
#include <span>
#include <sstream>

#include <vcd/baker/source.h>
#include <vcd/writer/atomic_file.h>

#include "command.h"
#include "this_program.h"

namespace vcd::farm {

using namespace tools;
using namespace library;
namespace {

namespace fs = std::filesystem;

// Slurm's MaxArraySize is 1001 unless an administrator changed it: larger plans are several arrays, each with an
// offset.
constexpr unsigned kArraySize = 1000;

}  // namespace

Result<Slurm> Slurm::find(const FarmPlan& plan) {
  for (const char* program : {"sbatch", "squeue"})
    if (const auto version = output_of({program, "--version"}); !version) return version.error();
  return Slurm(plan);
}

std::string Slurm::job_name() const {
  return "vc-farm-" + hex(baker::content_hash(plan_->folder.string())).substr(0, 8);
}

std::optional<Error> Slurm::submit(const std::vector<unsigned>& shards, const SlurmOptions& options) {
  std::map<unsigned, std::vector<unsigned>> arrays;
  for (const unsigned shard : shards) arrays[(shard - 1) / kArraySize * kArraySize].push_back(shard);
  for (const auto& [offset, numbers] : arrays)
    if (auto fault = submit_array(numbers, offset, options)) return fault;
  return std::nullopt;
}

std::optional<Error> Slurm::submit_array(const std::vector<unsigned>& shards, unsigned offset,
                                         const SlurmOptions& options) {
  std::string script = "#!/bin/sh\nexec " + shell_word(program_folder() / "vc-farm") + " run " +
                       shell_word(plan_->folder) + " $((" + std::to_string(offset) +
                       " + SLURM_ARRAY_TASK_ID)) -j \"${SLURM_CPUS_PER_TASK:-1}\" "
                       "${SLURM_MEM_PER_NODE:+--memory-mb=$SLURM_MEM_PER_NODE}";
  for (const std::string& argument : options.bake) script += " " + shell_word(argument);
  script += "\n";
  const fs::path path = plan_->folder / ("slurm-" + std::to_string(offset) + ".sh");
  AtomicFile file(path);
  file.append(std::as_bytes(std::span(script)));
  if (const auto written = file.commit(); !written) return written.error();

  std::string tasks;
  for (const unsigned shard : shards) tasks += (tasks.empty() ? "" : ",") + std::to_string(shard - offset);
  std::vector<std::string> command = {"sbatch",
                                      "--parsable",
                                      "--requeue",
                                      "--job-name=" + job_name() + "-" + std::to_string(offset),
                                      "--array=" + tasks,
                                      "--chdir=" + plan_->folder.string(),
                                      "--output=" + (plan_->folder / "slurm-%A_%a.out").string(),
                                      "--open-mode=append",
                                      "--cpus-per-task=" + std::to_string(options.threads)};
  command.insert(command.end(), options.arguments.begin(), options.arguments.end());
  command.push_back(path.string());
  if (const auto answer = output_of(command); !answer) return answer.error();
  return std::nullopt;
}

Result<Slurm::Queue> Slurm::queue() const {
  // Asked for by name: of a job that it has forgotten by number, squeue says the same as of a controller that is away.
  const auto answer = output_of({"squeue", "--me", "--noheader", "--array", "--format=%j %K %r"});
  if (!answer) return answer.error();
  Queue queue;
  std::istringstream lines(*answer);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string name, reason;
    unsigned task = 0, offset = 0;
    if (!(words >> name >> task) || !name.starts_with(job_name() + "-")) continue;
    std::getline(words, reason);
    std::from_chars(name.data() + job_name().size() + 1, name.data() + name.size(), offset);
    queue.shards.insert(offset + task);
    if (reason.find("eld") != std::string::npos)
      queue.held.insert(offset + task);  // JobHeldUser, launch failed requeued held, …
  }
  return queue;
}

}  // namespace vcd::farm
