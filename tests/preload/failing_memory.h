// Lets an allocation of libvcd_embree3 fail.
#pragma once

#include <cstddef>
#include <cstdint>

// How many more of this thread's succeed before one fails; SIZE_MAX: all.
extern thread_local size_t allocations_left;
