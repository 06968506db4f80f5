// The runtime's queries on files that are whole but whose trees, boxes and margins say anything, with any segments.
#include <algorithm>
#include <optional>
#include <vector>

#include <vcd/runtime/scene.h>
#include <vcd/runtime/sidecar.h>

#include "fuzz/hostile_floats.h"
#include "fuzz/runtime_promises.h"
#include "fuzz/scene_promises.h"
#include "fuzz/sidecar_mutator.h"

namespace vcd::fuzz {
namespace {

struct Input {
  AlignedBytes file;
  std::span<const uint8_t> tail;

  Input(const uint8_t* data, size_t size) {
    size_t end = size;
    if (size >= sizeof(FileHeader)) {
      FileHeader header;
      std::memcpy(&header, data, sizeof header);
      end = static_cast<size_t>(std::min<uint64_t>(header.file_size, size));
    }
    file = allocate_aligned(end);
    if (end > 0) std::memcpy(file.data.get(), data, end);
    tail = {data + end, size - end};
  }
  Bytes bytes() const { return {file.data.get(), file.size}; }
};

// The same file by every kernel.
struct Opened {
  CheckLevel check;
  bool proven_only;
  std::vector<Sidecar> by_kernel;

  static std::optional<Opened> open(Bytes bytes, CheckLevel check, bool proven_only) {
    Opened opened{check, proven_only, {}};
    for (const std::string& kernel : kernels()) {
      auto sidecar = Sidecar::open_buffer(bytes, {.check = check, .proven_only = proven_only, .kernel = kernel});
      if (!sidecar) return std::nullopt;
      opened.by_kernel.push_back(std::move(*sidecar));
    }
    return opened;
  }
};

std::vector<Answer> segment_answers(const Opened& opened, size_t index, const std::vector<Segment>& segments) {
  const Object first = opened.by_kernel[0].object(index);
  std::vector<Answer> alone;
  for (const Segment& s : segments) {
    alone.push_back(first.classify(s));
    require_answer(opened.by_kernel[0].contents().objects[index], s, alone.back(), opened.proven_only, opened.check == CheckLevel::full);
    bool asked = false;
    const bool occluded = first.occluded(s, [&] { return asked = true; });
    require(asked == (alone.back() == Answer::unclassified) && occluded == (alone.back() != Answer::clear), "the fallback decides what is open");
  }
  const SegmentColumns columns(segments);
  for (const Sidecar& sidecar : opened.by_kernel) {
    std::vector<Answer> array(segments.size(), Answer::blocked), arrays = array;
    sidecar.object(index).classify(segments, array);
    sidecar.object(index).classify(columns.view(), arrays);
    require(array == alone && arrays == alone, "arrays are answered as single segments, by every kernel");
  }
  return alone;
}

template <class Bundle>
Bits bundle_answers(const Opened& opened, size_t index, const Bundle& bundle) {
  Bits first(bundle.size());
  for (const Sidecar& sidecar : opened.by_kernel) {
    Bits bits(bundle.size());
    sidecar.object(index).classify(bundle, bits.blocked, bits.open);
    bits.require_well_formed();
    if (&sidecar == &opened.by_kernel[0]) first = bits;
    require(bits == first, "bundles are answered alike by every kernel");
  }
  return first;
}

void query_objects(const Opened& all, const Opened& proven, std::span<const uint8_t> tail) {
  for (size_t i = 0; i < std::min<size_t>(all.by_kernel[0].object_count(), 4); ++i) {
    const ObjectRecord& record = all.by_kernel[0].object(i).record();
    const auto segments = hostile_segments(HostileFloats(tail), record);
    const auto answers = segment_answers(all, i, segments), proofs = segment_answers(proven, i, segments);
    for (size_t k = 0; k < segments.size(); ++k) require_no_more(proofs[k], answers[k]);
    const HostileBundles bundles(HostileFloats(tail), record);
    bundle_answers(all, i, bundles.quad), bundle_answers(all, i, bundles.sphere);
    bundle_answers(proven, i, bundles.quad), bundle_answers(proven, i, bundles.sphere);
  }
}

bool query(Bytes bytes, CheckLevel check, std::span<const uint8_t> tail) {
  const auto all = Opened::open(bytes, check, false), proven = Opened::open(bytes, check, true);
  require(all.has_value() == proven.has_value(), "whether a file opens does not depend on what of it is trusted");
  if (!all) return false;
  query_objects(*all, *proven, tail);
  query_scene(all->by_kernel[0], tail);
  query_scene(proven->by_kernel[0], tail);
  return true;
}

}  // namespace
}  // namespace vcd::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace vcd;
  const fuzz::Input input(data, size);
  const bool full = fuzz::query(input.bytes(), CheckLevel::full, input.tail);
  if (!full) fuzz::query(input.bytes(), CheckLevel::bounds, input.tail);
  if (full) fuzz::planted_bug();
  return 0;
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size, unsigned int seed) {
  return vcd::fuzz::mutate_sidecar(data, size, max_size, seed, true);
}
