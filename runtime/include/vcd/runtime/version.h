/* The runtime's version: of these headers, and of the library that is linked. In C and in C++. */
#ifndef VCD_RUNTIME_VERSION_H
#define VCD_RUNTIME_VERSION_H

#include <stdint.h>

/* The build fails if these are not the project's. */
#define VCD_RUNTIME_VERSION_MAJOR 1
#define VCD_RUNTIME_VERSION_MINOR 6
#define VCD_RUNTIME_VERSION_PATCH 0

/* As one number that grows with the version: 1.2.3 is 1002003. */
#define VCD_RUNTIME_VERSION \
  (VCD_RUNTIME_VERSION_MAJOR * 1000000 + VCD_RUNTIME_VERSION_MINOR * 1000 + VCD_RUNTIME_VERSION_PATCH)

#ifdef __cplusplus
extern "C" {
#endif

/* VCD_RUNTIME_VERSION as it was when the library was built. */
uint32_t vcd_runtime_version(void);
/* "1.2.3": a static string. */
const char* vcd_runtime_version_string(void);

#ifdef __cplusplus
}

namespace vcd {

inline uint32_t runtime_version() noexcept { return vcd_runtime_version(); }
inline const char* runtime_version_string() noexcept { return vcd_runtime_version_string(); }

}  // namespace vcd
#endif
#endif
