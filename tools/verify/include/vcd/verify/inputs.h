// What the user names → files.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <vcd/library/find.h>
#include <vcd/verify/outcome.h>

namespace vcd::verify {

// A file, or the fault of an input that is not there or holds nothing of its kind.
struct Input {
  library::FoundFile file;
  std::optional<Outcome> fault;
};

// In the order of the names; each file once. kind: "sidecar" or "mesh", for messages. A name without any file of its
// kind is a fault, never nothing.
std::vector<Input> find_inputs(const std::vector<std::string>& names, const std::vector<std::string>& extensions,
                               const std::string& kind);

}  // namespace vcd::verify
