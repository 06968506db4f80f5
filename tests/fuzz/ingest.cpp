// One mesh format through ingest() and prepare(). VCD_FUZZ_EXTENSION is the format's; VCD_FUZZ_CALLS_LIBRARIES is 1
// where code that is not ours may throw, and where a file may name others that are missing.
#include <string>

#include "fuzz/memory_file.h"
#include "fuzz/mesh_promises.h"

namespace vcd::fuzz {
namespace {

bool may_fail_with(ErrorCode code) {
  if (code == ErrorCode::invalid_file || code == ErrorCode::unsupported) return true;
  return VCD_FUZZ_CALLS_LIBRARIES && (code == ErrorCode::io || code == ErrorCode::runtime);
}

void ingest_bytes(const uint8_t* data, size_t size) {
  static const MemoryFile file("input" VCD_FUZZ_EXTENSION);
  file.fill(data, size);
  baker::IngestOptions options;
  options.placements = true;
  options.treat_all_as_opaque = size % 2 == 0;
  options.subdivide = size % 3 == 0;
  Result<baker::Ingested> result = baker::ingest(file.path(), options);
  if (!result) {
    require(result.error().message.starts_with(file.path().string() + ": "), "an error names the file");
    if (!may_fail_with(result.error().code))
      broken("error code " + std::to_string(static_cast<int>(result.error().code)) + ": " + result.error().message);
    return;
  }
  require_ingested(*result);
  for (baker::SourceMesh& mesh : result->meshes) require_prepare_holds(std::move(mesh));
  planted_bug();
}

}  // namespace
}  // namespace vcd::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  vcd::fuzz::ingest_bytes(data, size);
  return 0;
}
