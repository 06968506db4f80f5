// The runtime's queries on files that are whole but whose trees, boxes and margins say anything, with any segments.
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <vcd/runtime/scene.h>
#include <vcd/runtime/sidecar.h>

#include "fuzz/horizon_promises.h"
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
  bool sound;  // the canonical check accepts it
  bool proven_only;
  std::vector<Sidecar> by_kernel;

  static std::optional<Opened> open(Bytes bytes, bool sound, bool proven_only) {
    Opened opened{sound, proven_only, {}};
    for (const std::string& kernel : kernels()) {
      auto sidecar =
          Sidecar::open_buffer(bytes, {.check = CheckLevel::bounds, .proven_only = proven_only, .kernel = kernel});
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
    require_answer(opened.by_kernel[0].contents().objects[index], s, alone.back(), opened.proven_only, opened.sound);
    bool asked = false;
    const bool occluded = first.occluded(s, [&] { return asked = true; });
    require(asked == (alone.back() == Answer::unclassified) && occluded == (alone.back() != Answer::clear),
            "the fallback decides what is open");
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

// Whether a line so close to the sample's that rounding may take one for the other is answered so.
bool neighbour_says(const Object& object, const Segment& s, Answer answer) {
  const ObjectRecord& record = object.record();
  for (int shift = 0; shift < 27; ++shift) {
    Segment near = s;
    for (int a = 0, digits = shift; a < 3; ++a, digits /= 3)
      near.direction[a] += static_cast<float>(digits % 3 - 1) * 0x1p-12f * (record.box_max[a] - record.box_min[a]);
    if (object.classify(near) == answer) return true;
  }
  return false;
}

// What single look-ups say, or more where they say nothing: a segment too short or too long to be looked up, or within
// rounding of a border.
void require_as_alone(const Object& object, const QuadBundle& bundle, const Bits& bits) {
  for (size_t i = 0; i < bundle.size(); ++i) {
    const Segment s = segment_of(bundle, i);
    const Answer alone = object.classify(s), together = bits[i];
    if (!test::is_finite(s))
      require(together == Answer::unclassified, "12: what is not finite is unclassified, in bundles too");
    require(together != Answer::unclassified || alone == together, "a bundle answers all that single look-ups answer");
    require(together == alone || alone == Answer::unclassified || neighbour_says(object, s, together),
            "a bundle says what single look-ups say");
  }
}
void require_as_alone(const Object&, const SphereBundle&, const Bits&) {}  // samples may lie outside of the sphere

template <class Bundle>
Bits bundle_answers(const Opened& opened, size_t index, const Bundle& bundle) {
  Bits first(bundle.size());
  for (const Sidecar& sidecar : opened.by_kernel) {
    const Object object = sidecar.object(index);
    Bits bits(bundle.size());
    object.classify(bundle, bits.blocked, bits.open);
    bits.require_well_formed();
    if (&sidecar == &opened.by_kernel[0]) first = bits;
    if (sidecar.kernel() == "scalar") {
      for (size_t i = 0; i < bundle.size(); ++i)
        require(bits[i] == object.classify(segment_of(bundle, i)), "the scalar kernel looks up each sample");
    } else {
      require(bits == first, "bundles are answered alike by every kernel that takes them together");
      require_as_alone(object, bundle, bits);
    }
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
    require_horizons_as_the_rule(all.by_kernel, i, tail);
  }
}

}  // namespace
}  // namespace vcd::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace vcd;
  using namespace vcd::fuzz;
  const Input input(data, size);
  const bool sound = Sidecar::open_buffer(input.bytes(), {.check = CheckLevel::canonical}).ok();
  const auto all = Opened::open(input.bytes(), sound, false), proven = Opened::open(input.bytes(), sound, true);
  require(all.has_value() == proven.has_value() && (all || !sound),
          "whether a file opens does not depend on what of it is trusted");
  if (!all) return 0;
  query_objects(*all, *proven, input.tail);
  query_scene(all->by_kernel[0], input.tail);
  query_scene(proven->by_kernel[0], input.tail);
  if (sound) planted_bug();
  return 0;
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size, unsigned int seed) {
  return vcd::fuzz::mutate_sidecar(data, size, max_size, seed, true);
}
