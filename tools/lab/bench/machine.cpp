#include "machine.h"

#include <fstream>
#include <thread>

#include <embree3/rtcore.h>
#include <sched.h>
#include <sys/utsname.h>
#include <unistd.h>

#include "render/instructions.h"

namespace vcd::bench {

using namespace tools;
namespace {

std::string processor_name() {
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

// The widest packets that Embree traces without cutting them up tell the instructions that it uses.
std::string embree_instructions() {
  const RTCDevice device = rtcNewDevice(render::embree_config());
  const bool sixteen = rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0;
  const bool eight = rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) != 0;
  rtcReleaseDevice(device);
  return sixteen ? "AVX-512" : eight ? "AVX or AVX2" : "SSE";
}

}  // namespace

Json describe_machine() {
  utsname system{};
  uname(&system);
  cpu_set_t allowed;
  return {
      {"processor", processor_name()},
      {"threads", std::thread::hardware_concurrency()},
      {"memory_bytes", static_cast<uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<uint64_t>(sysconf(_SC_PAGESIZE))},
      {"system", std::string(system.sysname) + " " + system.release},
#ifdef __clang__
      {"compiler", "Clang " __clang_version__},
#else
      {"compiler", "GCC " __VERSION__},
#endif
      {"embree", RTC_VERSION_STRING},
      {"embree_isa", embree_instructions()},
      {"pinned", sched_getaffinity(0, sizeof allowed, &allowed) == 0}};
}

std::string machine_description() {
  const Json m = describe_machine();
  return m["processor"].get<std::string>() + ", " + std::to_string(m["threads"].get<unsigned>()) + " threads; " +
         m["compiler"].get<std::string>() + "; Embree " + m["embree"].get<std::string>() + ", " +
         m["embree_isa"].get<std::string>();
}

}  // namespace vcd::bench
