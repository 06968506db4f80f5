#include "limits.h"

#include <sched.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace vcd::tools {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kNone = std::numeric_limits<uint64_t>::max();

std::optional<uint64_t> to_number(std::string_view text) {
  uint64_t number = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
  return fault == std::errc() && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

// The words of a file of one line, such as "max 100000".
std::vector<std::string> words_of(const fs::path& file) {
  std::ifstream stream(file);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

// Nothing for "max", "-1", and where there is no such file.
std::optional<uint64_t> number_in(const fs::path& file) {
  const auto words = words_of(file);
  return words.empty() ? std::nullopt : to_number(words[0]);
}

// The number after a key in a file of lines "KEY NUMBER", with or without a colon.
std::optional<uint64_t> number_after(const fs::path& file, const std::string& key) {
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    std::istringstream words(line);
    std::string word, number;
    if (words >> word >> number && (word == key || word == key + ":")) return to_number(number);
  }
  return std::nullopt;
}

bool has_word(const std::string& list, const std::string& word) {
  return ("," + list + ",").find("," + word + ",") != std::string::npos;
}

// A hierarchy of control groups, as it is mounted.
struct Mount {
  fs::path folder;
  std::string root;     // of the hierarchy, the group that stands at `folder`
  std::string options;  // version 1: its controllers, with commas
};

// The mounts of "cgroup2", or of "cgroup" with that controller.
std::vector<Mount> mounts_of(const Surroundings& around, const std::string& kind, const std::string& controller) {
  std::vector<Mount> mounts;
  std::ifstream stream(around.root / "proc/self/mountinfo");
  for (std::string line; std::getline(stream, line);) {
    std::istringstream words(line);
    std::string number, parent, device, root, folder, word, type, source, options;
    words >> number >> parent >> device >> root >> folder;
    while (words >> word && word != "-") {
    }
    words >> type >> source >> options;
    if (type == kind && (controller.empty() || has_word(options, controller)))
      mounts.push_back({around.root / fs::path(folder).relative_path(), root, options});
  }
  if (!mounts.empty()) return mounts;
  // Where they are mounted as a rule.
  const fs::path usual = around.root / "sys/fs/cgroup";
  if (controller.empty()) return {{usual, "/", ""}, {usual / "unified", "/", ""}};
  return {{usual / controller, "/", controller}, {usual / "cpu,cpuacct", "/", controller}};
}

// The path of this process's group in a hierarchy; nothing if it is in none.
std::optional<std::string> group_of(const Surroundings& around, const std::string& controller) {
  std::ifstream stream(around.root / "proc/self/cgroup");
  for (std::string line; std::getline(stream, line);) {  // "NUMBER:CONTROLLERS:PATH"
    const size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    if (controller.empty() ? controllers.empty() : has_word(controllers, controller)) return line.substr(second + 1);
  }
  return std::nullopt;
}

// The folders of this process's group and of all groups that hold it, as far as they are to be seen here.
std::vector<fs::path> groups(const Surroundings& around, const std::string& kind, const std::string& controller) {
  const auto group = group_of(around, controller);
  if (!group) return {};
  std::vector<fs::path> folders;
  for (const Mount& mount : mounts_of(around, kind, controller)) {
    // In a container, the path may be that of the host, which has another root, or is none that is to be seen.
    fs::path below = fs::path(*group).lexically_relative(mount.root);
    std::error_code error;
    if (below.empty() || *below.begin() == ".." || !fs::is_directory(mount.folder / below, error)) below = ".";
    for (fs::path path = (mount.folder / below).lexically_normal();; path = path.parent_path()) {
      folders.push_back(path);
      const fs::path rest = path.lexically_relative(mount.folder.lexically_normal());
      if (rest.empty() || rest == "." || *rest.begin() == ".." || !path.has_relative_path()) break;
    }
  }
  return folders;
}

// Of a limit, what is not in use; file pages that nobody needs count as free.
uint64_t left_of(std::optional<uint64_t> limit, std::optional<uint64_t> used, std::optional<uint64_t> inactive) {
  if (!limit) return kNone;
  const uint64_t in_use = used.value_or(0) - std::min(used.value_or(0), inactive.value_or(0));
  return *limit - std::min(*limit, in_use);
}

uint64_t memory_of_groups(const Surroundings& around) {
  uint64_t least = kNone;
  for (const fs::path& group : groups(around, "cgroup2", "")) {
    const auto used = number_in(group / "memory.current"),
               inactive = number_after(group / "memory.stat", "inactive_file");
    for (const char* limit : {"memory.max", "memory.high"})
      least = std::min(least, left_of(number_in(group / limit), used, inactive));
  }
  for (const fs::path& group : groups(around, "cgroup", "memory")) {
    const auto used = number_in(group / "memory.usage_in_bytes"),
               inactive = number_after(group / "memory.stat", "total_inactive_file");
    for (const auto& limit :
         {number_in(group / "memory.limit_in_bytes"), number_after(group / "memory.stat", "hierarchical_memory_limit")})
      least = std::min(least, left_of(limit, used, inactive));
  }
  return least;
}

uint64_t memory_of_job(const Surroundings& around) {
  const auto variable = [&](const char* name) {
    const char* text = around.variable(name);
    return text ? to_number(text) : std::nullopt;
  };
  constexpr uint64_t kMebibyte = 1 << 20, kMost = kNone / kMebibyte;
  const auto bytes = [](uint64_t mebibytes) { return mebibytes > kMost ? kNone : mebibytes * kMebibyte; };
  // 0: all that the node has.
  if (const auto of_node = variable("SLURM_MEM_PER_NODE"); of_node && *of_node > 0) return bytes(*of_node);
  const auto of_processor = variable("SLURM_MEM_PER_CPU");
  if (!of_processor || *of_processor == 0) return kNone;
  for (const char* name : {"SLURM_CPUS_PER_TASK", "SLURM_CPUS_ON_NODE"})
    if (const auto count = variable(name); count && *count > 0)
      return *of_processor > kMost / *count ? kNone : bytes(*of_processor * *count);
  return bytes(*of_processor);
}

// Processors that a quota of so many microseconds in a period keeps busy.
unsigned busy(std::optional<uint64_t> quota, std::optional<uint64_t> period) {
  if (!quota || !period || *period == 0) return std::numeric_limits<unsigned>::max();
  const double processors = std::ceil(static_cast<double>(*quota) / static_cast<double>(*period));
  return static_cast<unsigned>(std::clamp(processors, 1.0, 1e6));
}

}  // namespace

uint64_t available_memory(const Surroundings& surroundings) {
  const auto free = number_after(surroundings.root / "proc/meminfo", "MemAvailable");
  const uint64_t least =
      std::min({free ? *free * 1024 : kNone, memory_of_groups(surroundings), memory_of_job(surroundings)});
  return least == kNone ? 0 : std::max<uint64_t>(least, 1);
}

unsigned available_processors(const Surroundings& surroundings) {
  unsigned least = surroundings.processors;
  cpu_set_t set;
  if (least == 0) least = sched_getaffinity(0, sizeof set, &set) == 0 ? static_cast<unsigned>(CPU_COUNT(&set)) : 1;
  for (const fs::path& group : groups(surroundings, "cgroup2", ""))
    if (const auto words = words_of(group / "cpu.max"); words.size() == 2)
      least = std::min(least, busy(to_number(words[0]), to_number(words[1])));
  for (const fs::path& group : groups(surroundings, "cgroup", "cpu"))
    least = std::min(least, busy(number_in(group / "cpu.cfs_quota_us"), number_in(group / "cpu.cfs_period_us")));
  return std::max(least, 1u);
}

}  // namespace vcd::tools
