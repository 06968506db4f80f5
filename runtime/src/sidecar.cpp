#include <vcd/runtime/sidecar.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <new>
#include <utility>
#include <vector>

#include <vcd/format/contents.h>
#include <vcd/format/file_bytes.h>
#include <vcd/format/tree.h>

#include "beam/beam.h"
#include "hierarchy/fan.h"
#include "lookup/grids.h"
#include "lookup/object_data.h"
#include "lookup/sample_bits.h"

namespace vcd {

struct Sidecar::State {
  FileBytes file;
  SidecarContents contents;
  std::vector<ObjectData> objects;
  const char* kernel;  // its name
};

namespace {

// One a depth, so that every shift and mask is a constant.
template <uint32_t kDepth>
Visibility classify_at(const GridFrame& frame, const TreeView& tree, const Segment& segment) noexcept {
  return classify(frame, tree, tree_shape(kDepth), segment);
}
template <uint32_t kDepth>
Visibility classify_placed_at(const TreeView& tree, const PlacedSegment& placed) noexcept {
  const LineCell line = located(placed).line;
  const float t_min = placed.in_grid.t_min, t_max = placed.in_grid.t_max;
  const Place place = place_of(line, t_min, t_max);
  return look_up(tree, tree_shape(kDepth), widened(place, tree.clearances, line, t_min, t_max), line);
}
using DepthNumbers = std::make_integer_sequence<uint32_t, kMaxDepth>;
constexpr auto kClassifyOne = []<uint32_t... kDepths>(std::integer_sequence<uint32_t, kDepths...>) {
  return std::array{&classify_at<kDepths + 1>...};
}
(DepthNumbers());
constexpr auto kClassifyPlaced = []<uint32_t... kDepths>(std::integer_sequence<uint32_t, kDepths...>) {
  return std::array{&classify_placed_at<kDepths + 1>...};
}
(DepthNumbers());

Visibility unclassified_one(const GridFrame&, const TreeView&, const Segment&) noexcept {
  return Visibility::unclassified;
}
Visibility unclassified_placed(const TreeView&, const PlacedSegment&) noexcept { return Visibility::unclassified; }
constexpr TraceKernels kNoHierarchy = {
    [](const Traced&, const Segment&) noexcept -> bool { fail_without_hierarchy(); },
    [](const Traced&, const LookUpOne&, const Segment&) noexcept -> bool { fail_without_hierarchy(); },
    [](const Traced&, const Segment*, const SampleBits&) noexcept -> SampleBits { fail_without_hierarchy(); },
    [](const Traced&, const Fan&) noexcept -> SampleBits { fail_without_hierarchy(); },
    [](const ReachBox&, const Segment*, const SampleBits&) noexcept -> SampleBits { fail_without_hierarchy(); }};

// Sets look_up_arrays and its kin.
void decide_look_ups(ObjectData& data, LookUpFirst how, uint16_t version_minor) {
  const auto looks_up = [&](uint16_t flag) {
    return data.kernels &&
           (how == LookUpFirst::always || (how == LookUpFirst::as_baked && (data.record->flags & flag) != 0));
  };
  for (const From from : {From::outside, From::inside}) {
    const bool outside = from == From::outside;
    const auto at = static_cast<size_t>(from);
    const uint16_t arrays = outside ? kLookUpFromOutside : kLookUpFromInside,
                   bundles = outside ? kLookUpTogetherFromOutside : kLookUpTogetherFromInside,
                   one = outside ? kLookUpOneFromOutside : kLookUpOneFromInside;
    data.look_up_arrays[at] = looks_up(arrays);
    data.look_up_bundles[at] = looks_up(version_minor < 1 ? arrays : bundles);
    data.look_up_one[at] = looks_up(version_minor < 2 ? arrays : one);
  }
  const auto outside = static_cast<size_t>(From::outside);
  data.look_up_in_scene = version_minor < 2 ? data.look_up_bundles[outside] : data.look_up_one[outside];
  data.box_first = data.record->method == static_cast<uint8_t>(Method::proven);
}

}  // namespace

Sidecar::Sidecar(std::unique_ptr<State> state) : state_(std::move(state)) {}
Sidecar::Sidecar(Sidecar&&) noexcept = default;
Sidecar& Sidecar::operator=(Sidecar&&) noexcept = default;
Sidecar::~Sidecar() = default;

Result<Sidecar> Sidecar::read(std::unique_ptr<State> state, Bytes bytes, const OpenOptions& options,
                              const std::string& name) {
  std::vector<Finding> findings;
  auto contents = read_sidecar(bytes, options.check, findings);
  if (!contents) return first_error(name, findings);
  state->contents = std::move(*contents);
  const Kernels* const chosen = kernels_named(options.kernel);
  if (!chosen)
    return Error{ErrorCode::usage, "kernel \"" + options.kernel + "\": this processor has none of that name"};
  state->kernel = chosen->name;
  for (const ObjectContents& object : state->contents.objects) {
    const ObjectRecord& record = *object.record;
    ObjectData data{};
    data.frame = make_grid_frame(record.box_min, record.box_max);
    data.tree = object.tree;
    data.classify_one = unclassified_one;
    data.classify_placed = unclassified_placed;
    data.record = &record, data.name = object.name;
    data.box = reach_box(record.box_min, record.box_max), data.traced = traced(object.hierarchy);
    data.trace = object.hierarchy ? &chosen->trace : &kNoHierarchy;
    data.horizons = {object.horizon, object.hierarchy};
    data.horizon = &chosen->horizon;
    const auto method = static_cast<Method>(record.method);
    if (method != Method::none && !(options.proven_only && method == Method::sampled)) {
      data.classify_one = kClassifyOne[record.depth - 1u];
      data.classify_placed = kClassifyPlaced[record.depth - 1u];
      data.kernels = &kernels_for(data.tree, *chosen);
    }
    if (options.proven_only) data.tree.answers = answer_table(Trust::proofs, classes_in(record));
    decide_look_ups(data, options.look_up, state->contents.header->version_minor);
    state->objects.push_back(data);
  }
  return Sidecar(std::move(state));
}

Result<Sidecar> Sidecar::open(const std::filesystem::path& path, const OpenOptions& options) {
  try {
    auto file = options.load == Load::map ? FileBytes::map(path) : FileBytes::copy(path);
    if (!file) return file.error();
    auto state = std::make_unique<State>();
    state->file = std::move(*file);
    const Bytes bytes = state->file.bytes();
    return read(std::move(state), bytes, options, path.string());
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::runtime, path.string() + ": out of memory"};
  }
}

Result<Sidecar> Sidecar::open_buffer(Bytes bytes, const OpenOptions& options) {
  try {
    if (reinterpret_cast<uintptr_t>(bytes.data()) % 8 != 0)
      return Error{ErrorCode::usage, "buffer: its address is not a multiple of 8"};
    return read(std::make_unique<State>(), bytes, options, "buffer");
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::runtime, "buffer: out of memory"};
  }
}

size_t Sidecar::object_count() const noexcept { return state_->objects.size(); }
Object Sidecar::object(size_t index) const noexcept {
  assert(index < object_count());
  return Object(&state_->objects[index]);
}

std::optional<Object> Sidecar::find(std::string_view name) const noexcept {
  for (const ObjectData& object : state_->objects)
    if (object.name == name) return Object(&object);
  return std::nullopt;
}

std::optional<Object> Sidecar::find(const std::array<uint8_t, 16>& geometry_hash) const noexcept {
  for (const ObjectData& object : state_->objects)
    if (object.record->geometry_hash == geometry_hash) return Object(&object);
  return std::nullopt;
}

std::string_view Sidecar::kernel() const noexcept { return state_->kernel; }

std::vector<std::string> kernels() {
  std::vector<std::string> names;
  for (const Kernels* kernels : usable_kernels()) names.push_back(kernels->name);
  return names;
}

const SidecarContents& Sidecar::contents() const noexcept { return state_->contents; }

}  // namespace vcd
