#include "configuration.h"

#include "common/describe.h"

namespace vcd::bench {

using tools::method_name;

std::optional<Configuration> Configuration::parse(const std::string& text) {
  const size_t cross = text.find('x');
  if (cross != 1 || text[0] < '1' || text[0] > '8') return std::nullopt;
  const std::string kind = text.substr(cross + 1);
  Configuration c{static_cast<uint32_t>(text[0] - '0'), Method::sampled, 256};
  if (kind == "proven" || kind == "hybrid") {
    c.method = kind == "proven" ? Method::proven : Method::hybrid, c.samples = 0;
    return c;
  }
  for (uint32_t samples : {16, 81, 256})
    if (kind == std::to_string(samples)) return c.samples = samples, c;
  return std::nullopt;
}

std::string Configuration::text() const {
  return std::to_string(depth) + "x" + (method == Method::sampled ? std::to_string(samples) : method_name(method));
}

std::string Configuration::id() const {
  return "d" + std::to_string(depth) + "-" +
         (method == Method::sampled ? "n" + std::to_string(samples) : method_name(method));
}

}  // namespace vcd::bench
