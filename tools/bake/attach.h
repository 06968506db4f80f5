// vc-bake --attach: the asset again, with its sidecar.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <vcd/format/error.h>

#include <vcd/library/assets.h>

namespace vcd::tools {

struct AttachRequest {
  std::string to;      // the file to write; empty: none
  bool embed = false;  // the sidecar itself
};

// Why it cannot be done, as far as that can be known before the bake. Errors: usage; io.
std::optional<Error> check_attach(const AttachRequest& request, const library::Asset& asset);

// After the bake. Errors: those of baker::attach() and AtomicFile; io (the mesh file or the sidecar cannot be read, or
// the sidecar was made of another version of the mesh file).
std::optional<Error> write_attached(const AttachRequest& request, const library::Asset& asset);

}  // namespace vcd::tools
