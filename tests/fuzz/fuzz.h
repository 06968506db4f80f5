// What all fuzz targets share: how a broken promise ends, and the bugs that a self-test plants.
#pragma once

#include <climits>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>

namespace vcd::fuzz {

// Ends the process with the reason, so that libFuzzer keeps the input.
[[noreturn]] inline void broken(const std::string& promise) {
  std::fprintf(stderr, "BROKEN PROMISE: %s\n", promise.c_str());
  std::abort();
}

inline void require(bool holds, const char* promise) {
  if (!holds) broken(promise);
}

// Targets call this where an input has come through every check. With VCD_FUZZ_PLANT in the environment (property,
// memory or undefined) a bug stands here, which `run.py --self-test` must see.
inline void planted_bug() {
  static const char* const planted = std::getenv("VCD_FUZZ_PLANT");
  if (planted == nullptr) return;
  const std::string_view kind = planted;
  if (kind == "property") broken("planted");
  if (kind == "memory") {
    const std::unique_ptr<char[]> block(new char[8]);
    volatile size_t past_the_end = 8;
    volatile char read = block[past_the_end];
    static_cast<void>(read);
  }
  if (kind == "undefined") {
    volatile int most = INT_MAX;
    volatile int overflow = most + 1;
    static_cast<void>(overflow);
  }
}

}  // namespace vcd::fuzz

// libFuzzer's own: changes data[0 … size) in place, up to max_size bytes; returns the new size.
extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);
