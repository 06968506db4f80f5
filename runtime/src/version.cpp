#include <vcd/runtime/version.h>

// From the project() of CMakeLists.txt, which is the source of these numbers.
static_assert(VCD_RUNTIME_VERSION_MAJOR == VCD_PROJECT_VERSION_MAJOR &&
                  VCD_RUNTIME_VERSION_MINOR == VCD_PROJECT_VERSION_MINOR &&
                  VCD_RUNTIME_VERSION_PATCH == VCD_PROJECT_VERSION_PATCH,
              "<vcd/runtime/version.h> must have the version that CMakeLists.txt has");

extern "C" {

uint32_t vcd_runtime_version(void) { return VCD_RUNTIME_VERSION; }
const char* vcd_runtime_version_string(void) { return VCD_PROJECT_VERSION; }

}  // extern "C"
