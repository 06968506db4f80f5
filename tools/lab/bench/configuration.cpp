#include "configuration.h"

#include "common/describe.h"

namespace vcd::bench {

using tools::method_name;
namespace {

const std::string kForDemand = "demand";

}  // namespace

std::optional<Configuration> Configuration::parse(const std::string& text) {
  const size_t cross = text.find('x');
  if (cross == std::string::npos) return std::nullopt;
  const std::string depth = text.substr(0, cross), kind = text.substr(cross + 1);
  Configuration c{0, Method::sampled, 256, depth == kForDemand};
  if (!c.for_demand) {
    if (depth.size() != 1 || depth[0] < '1' || depth[0] > '8') return std::nullopt;
    c.depth = static_cast<uint32_t>(depth[0] - '0');
  }
  if (kind == "proven" || kind == "hybrid") {
    c.method = kind == "proven" ? Method::proven : Method::hybrid, c.samples = 0;
    return c;
  }
  for (uint32_t samples : {16, 81, 256})
    if (!c.for_demand && kind == std::to_string(samples)) return c.samples = samples, c;
  return std::nullopt;
}

std::string Configuration::text() const {
  return (for_demand ? kForDemand : std::to_string(depth)) + "x" +
         (method == Method::sampled ? std::to_string(samples) : method_name(method));
}

std::string Configuration::id() const {
  return (for_demand ? kForDemand : "d" + std::to_string(depth)) + "-" +
         (method == Method::sampled ? "n" + std::to_string(samples) : method_name(method));
}

}  // namespace vcd::bench
