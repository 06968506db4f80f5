#include "support/count_allocations.h"

#include <atomic>
#include <cstdlib>
#include <new>

static std::atomic<uint64_t> g_allocations{0};

void* operator new(std::size_t size) {
  ++g_allocations;
  if (void* p = std::malloc(size ? size : 1)) return p;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++g_allocations;
  return std::malloc(size ? size : 1);
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }

namespace vcd::test {

uint64_t allocation_count() { return g_allocations; }

}  // namespace vcd::test
