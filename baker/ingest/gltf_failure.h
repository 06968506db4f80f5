// How everything in this folder that is named gltf_* reports errors: by throwing GltfFailure, which keeps forty checks
// out of the way of the algorithm. ingest_gltf catches it, so that none leaves the folder.
#pragma once

#include <vcd/format/error.h>

#include <string>

namespace vcd::baker {

struct GltfFailure {
  Error error;  // the message names the place inside the file, and not yet the file
};

[[noreturn]] void fail_gltf(ErrorCode code, std::string message);
[[noreturn]] void fail_invalid(std::string message);

// A name from the file, quoted for a message: control characters become spaces, long names are cut.
std::string quoted(const std::string& name);

}  // namespace vcd::baker
