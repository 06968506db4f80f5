#include "packets.h"

namespace vcd::render {

std::string name_of(EmbreeQuery packets) {
  return "rtcOccluded" + std::to_string(packets.width) + (packets.coherent ? ", coherent" : "");
}

std::vector<EmbreeQuery> all_packets(bool instances) {
  if (instances) return {{1, false}, {8, false}, {16, false}};
  return {{1, false}, {1, true}, {8, false}, {8, true}, {16, false}, {16, true}};
}

}  // namespace vcd::render
