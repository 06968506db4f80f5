#include "settings.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace vcd::preload {
namespace {

std::string_view variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

Answers answers_of(std::string_view name) {
  if (name.empty() || name == "proven") return Answers::proven;
  if (name == "statistical") return Answers::statistical;
  if (name == "exact") return Answers::exact;
  if (name == "none") return Answers::none;
  std::fprintf(stderr, "libvcd_embree3: VCD_ANSWERS is proven, statistical, exact or none\n");
  std::exit(1);
}

bool is_always(std::string_view name) {
  if (name.empty() || name == "measured") return false;
  if (name == "always") return true;
  std::fprintf(stderr, "libvcd_embree3: VCD_LOOK_UP is measured or always\n");
  std::exit(1);
}

Settings read() {
  Settings settings;
  for (std::string_view left = variable("VCD_SIDECARS"); !left.empty();) {
    const size_t end = std::min(left.find(':'), left.size());
    if (end > 0) settings.sidecars.emplace_back(left.substr(0, end));
    left.remove_prefix(std::min(end + 1, left.size()));
  }
  settings.export_to = variable("VCD_EXPORT");
  settings.answers = answers_of(variable("VCD_ANSWERS"));
  settings.look_up_always = is_always(variable("VCD_LOOK_UP"));
  return settings;
}

}  // namespace

const Settings& settings() {
  static const Settings& kept = *new Settings(read());  // never destroyed: threads may still ask at exit
  return kept;
}

}  // namespace vcd::preload
