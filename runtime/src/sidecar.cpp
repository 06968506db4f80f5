#include <vcd/runtime/sidecar.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <new>
#include <utility>
#include <vector>

#include <vcd/format/contents.h>
#include <vcd/format/file_bytes.h>
#include <vcd/format/tree.h>

#include "bits.h"
#include "kernels.h"
#include "object_data.h"

namespace vcd {

struct Sidecar::State {
  FileBytes file;
  SidecarContents contents;
  std::vector<ObjectData> objects;
  const char* kernel;  // its name
};

namespace {

// One kernel a depth, so that every shift and mask is a constant.
template <uint32_t kDepth>
Visibility classify_at(const ObjectData& data, const Segment& segment) noexcept {
  return classify(data.frame, data.tree, tree_shape(kDepth), segment);
}
constexpr auto kClassifyOne = []<uint32_t... kDepths>(std::integer_sequence<uint32_t, kDepths...>) {
  return std::array{&classify_at<kDepths + 1>...};
}
(std::make_integer_sequence<uint32_t, kMaxDepth>());

// For objects that answer nothing.
Visibility unclassified_one(const ObjectData&, const Segment&) noexcept { return Visibility::unclassified; }
void unclassified_segments(const ObjectData&, std::span<const Segment> segments, Visibility* answers) {
  std::fill_n(answers, segments.size(), Visibility::unclassified);
}
void unclassified_arrays(const ObjectData&, const SegmentArrays& segments, Visibility* answers) {
  std::fill_n(answers, segments.count, Visibility::unclassified);
}
template <class Bundle>
void unclassified_bundle(const ObjectData&, const Bundle& bundle, uint64_t* blocked, uint64_t* open) {
  clear_bits(bundle.size(), blocked, open);
  for (size_t i = 0; i < bundle.size(); ++i) set_bits(Visibility::unclassified, i, blocked, open);
}
constexpr ManyKernels kUnclassified = {unclassified_segments, unclassified_arrays, nullptr,
                                       unclassified_bundle<QuadBundle>, unclassified_bundle<SphereBundle>};

Error first_error(const std::string& name, std::span<const Finding> findings) {
  for (const Finding& finding : findings) {
    if (finding_info(finding.id).severity != Severity::error) continue;
    return {error_code(finding.id), name + ": " + describe(finding)};
  }
  return {ErrorCode::invalid_file, name + ": not a valid sidecar"};
}

}  // namespace

Visibility Object::classify(const Segment& segment) const noexcept { return data_->classify_one(*data_, segment); }

void Object::classify(std::span<const Segment> segments, std::span<Visibility> answers) const noexcept {
  data_->many.segments(*data_, segments, answers.data());
}

void Object::classify(const SegmentArrays& segments, std::span<Visibility> answers) const noexcept {
  data_->many.arrays(*data_, segments, answers.data());
}

void Object::classify(const QuadBundle& bundle, std::span<uint64_t> blocked, std::span<uint64_t> open) const noexcept {
  data_->many.quad(*data_, bundle, blocked.data(), open.data());
}

void Object::classify(const SphereBundle& bundle, std::span<uint64_t> blocked,
                      std::span<uint64_t> open) const noexcept {
  data_->many.sphere(*data_, bundle, blocked.data(), open.data());
}

std::string_view Object::name() const noexcept { return data_->name; }
const ObjectRecord& Object::record() const noexcept { return *data_->record; }
bool Object::answers() const noexcept { return data_->classify_one != unclassified_one; }

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
  const std::vector<Kernels> usable = usable_kernels();
  const auto named = [&](const Kernels& k) { return options.kernel.empty() || options.kernel == k.name; };
  const auto chosen = std::find_if(usable.begin(), usable.end(), named);
  if (chosen == usable.end())
    return Error{ErrorCode::usage, "kernel \"" + options.kernel + "\": this processor has none of that name"};
  state->kernel = chosen->name;
  for (const ObjectContents& object : state->contents.objects) {
    ObjectData data{make_grid_frame(object.record->box_min, object.record->box_max),
                    object.tree,
                    object.record,
                    object.name,
                    unclassified_one,
                    kUnclassified};
    const auto method = static_cast<Method>(object.record->method);
    if (method != Method::none && !(options.proven_only && method == Method::sampled)) {
      const Kernels& kernels = fits_gathers(data.tree) ? *chosen : usable.back();
      const size_t depth = object.record->depth - 1u;
      data.classify_one = kClassifyOne[depth];
      data.many = kernels.at_depth[depth];
    }
    if (options.proven_only) {
      data.tree.blocked_answers = TreeView::kProvenAnswers;
      data.tree.has_blocked = object.record->cells[1] != 0;
    }
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
Object Sidecar::object(size_t index) const noexcept { return Object(&state_->objects[index]); }

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
  for (const Kernels& kernels : usable_kernels()) names.push_back(kernels.name);
  return names;
}

const SidecarContents& Sidecar::contents() const noexcept { return state_->contents; }

}  // namespace vcd
