// Writes a sidecar without objects, and reads it back.
#include <cstdio>

#include <vcd/writer/writer.h>

int main(int argc, char** argv) {
  vcd::SidecarToWrite sidecar;
  sidecar.provenance["baker"] = "an outsider";
  const auto written = vcd::write_sidecar(argc > 1 ? argv[1] : "", sidecar);
  if (!written) return std::fprintf(stderr, "%s\n", written.error().message.c_str()), 1;
  std::printf("%llu bytes\n", static_cast<unsigned long long>(*written));
}
