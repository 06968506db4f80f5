// Embree's own functions, which those of this library stand before.
#pragma once

#include <cstdio>
#include <cstdlib>

#include <dlfcn.h>
#include <embree3/rtcore.h>

namespace vcd::preload {

// Ends the program with a message if no Embree is loaded.
template <class Function>
Function* next(const char* name) {
  if (void* found = dlsym(RTLD_NEXT, name)) return reinterpret_cast<Function*>(found);
  std::fprintf(stderr, "libvcd_embree3: %s is in no library after this one\n", name);
  std::abort();
}

}  // namespace vcd::preload

// Found once, by the first call.
#define VCD_NEXT(function)                                                                      \
  ([]() -> decltype(function)* {                                                                \
    static decltype(function)* const found = vcd::preload::next<decltype(function)>(#function); \
    return found;                                                                               \
  }())
