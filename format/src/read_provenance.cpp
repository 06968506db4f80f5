// The PROV section: pairs of key and value.
#include <cstring>

#include <vcd/format/utf8.h>

#include "reading.h"

namespace vcd {
namespace {

// Takes numbers and texts off the front of bytes; false where there are too few.
struct Front {
  Bytes rest;

  bool number(uint32_t& value) {
    if (rest.size() < sizeof value) return false;
    std::memcpy(&value, rest.data(), sizeof value);
    rest = rest.subspan(sizeof value);
    return true;
  }
  bool text(uint32_t size, std::string_view& value) {
    if (rest.size() < size) return false;
    value = {reinterpret_cast<const char*>(rest.data()), size};
    rest = rest.subspan(size);
    return is_utf8(value);
  }
};

}  // namespace

void read_provenance(Reading& reading) {
  if (!reading.provenance) return;
  auto& pairs = reading.contents.provenance;
  Front front{reading.stored(*reading.provenance)};
  uint32_t count = 0;
  bool good = front.number(count);
  for (uint32_t i = 0; good && i < count; ++i) {
    uint32_t key_size = 0, value_size = 0;
    std::string_view key, value;
    good = front.number(key_size) && front.number(value_size) && front.text(key_size, key) &&
           front.text(value_size, value) && (pairs.empty() || pairs.back().first < key);
    if (good) pairs.emplace_back(key, value);
  }
  if (!good || !front.rest.empty()) reading.report(FindingId::provenance, reading.provenance->offset);
}

}  // namespace vcd
