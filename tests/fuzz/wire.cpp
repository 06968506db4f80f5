// What a child process hands back, as one that has been taken over would: any bytes.
#include <string>

#include "fuzz/memory_file.h"
#include "fuzz/mesh_promises.h"
#include "ingest/check.h"
#include "ingest/wire.h"

namespace vcd::fuzz {
using namespace baker;
namespace {

void read_back(const uint8_t* data, size_t size) {
  static const MemoryFile file("result"), copy("copy");
  file.fill(data, size);
  std::optional<Result<Ingested>> result = read_result(file.descriptor());
  if (!result) return;
  copy.fill(nullptr, 0);
  require(write_result(copy.descriptor(), *result), "a result can be written");
  require(copy.content() == std::string(reinterpret_cast<const char*>(data), size),
          "a result is written as it was read");
  if (result->ok() && !check_ingested(file.path(), **result)) {
    require_ingested(**result);
    planted_bug();
  }
}

}  // namespace
}  // namespace vcd::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  vcd::fuzz::read_back(data, size);
  return 0;
}
