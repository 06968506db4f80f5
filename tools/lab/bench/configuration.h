// What tree to bake of a scene, as the command line and the results name it.
#pragma once

#include <optional>
#include <string>

#include <vcd/format/layout.h>

namespace vcd::bench {

struct Configuration {
  uint32_t depth;
  Method method;
  uint32_t samples;         // as BakeOptions has them
  bool for_demand = false;  // of the same picture with another seed; then the baker picks the depth

  // "5x256", "5xproven", "5xhybrid", "demandxproven", "demandxhybrid" and back; nothing if it is none of these.
  static std::optional<Configuration> parse(const std::string& text);
  std::string text() const;

  std::string id() const;  // of files and in the results
};

}  // namespace vcd::bench
