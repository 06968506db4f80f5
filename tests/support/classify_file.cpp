// classify_file SIDECAR OBJECT SEGMENTS OUT: 32-byte segments in, one byte of answer each out, through the runtime.
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <vcd/format/file_bytes.h>
#include <vcd/runtime/sidecar.h>

int main(int argc, char** argv) {
  if (argc != 5) return 1;
  const auto sidecar = vcd::Sidecar::open(argv[1]);
  const auto segments = vcd::FileBytes::copy(argv[3]);
  if (!sidecar || !segments) return 2;
  const auto* first = reinterpret_cast<const vcd::Segment*>(segments->bytes().data());
  const size_t count = segments->bytes().size() / sizeof(vcd::Segment);
  std::vector<vcd::Visibility> answers(count);
  sidecar->object(static_cast<size_t>(std::atoi(argv[2]))).classify({first, count}, answers);
  std::FILE* out = std::fopen(argv[4], "wb");
  if (!out || std::fwrite(answers.data(), 1, count, out) != count) return 2;
  return std::fclose(out) == 0 ? 0 : 2;
}
