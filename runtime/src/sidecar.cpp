#include <vcd/runtime/sidecar.h>

#include <algorithm>
#include <cstdint>
#include <new>
#include <vector>

#include <vcd/format/contents.h>
#include <vcd/format/file_bytes.h>
#include <vcd/format/tree.h>

namespace vcd {

struct ObjectData {
  GridFrame frame;
  TreeView tree;
  const ObjectRecord* record;
  std::string_view name;
  // The kernels for the object's depth.
  Visibility (*classify_one)(const ObjectData&, const Segment&) noexcept;
  void (*classify_array)(const ObjectData&, std::span<const Segment>, Visibility*) noexcept;
};

struct Sidecar::State {
  FileBytes file;
  SidecarContents contents;
  std::vector<ObjectData> objects;
};

namespace {

// One kernel a depth, so that every shift and mask is a constant.
template <uint32_t kDepth>
struct Kernel {
  static constexpr TreeShape kShape = tree_shape(kDepth);
  static Visibility one(const ObjectData& data, const Segment& segment) noexcept {
    return classify(data.frame, data.tree, kShape, segment);
  }
  static void array(const ObjectData& data, std::span<const Segment> segments, Visibility* answers) noexcept {
    for (size_t i = 0; i < segments.size(); ++i)
      answers[i] = classify(data.frame, data.tree, kShape, segments[i]);
  }
};

// For objects that answer nothing.
Visibility unclassified_one(const ObjectData&, const Segment&) noexcept { return Visibility::unclassified; }
void unclassified_array(const ObjectData&, std::span<const Segment> segments, Visibility* answers) noexcept {
  std::fill_n(answers, segments.size(), Visibility::unclassified);
}

template <uint32_t... kDepths>
void choose_kernels(ObjectData& data, std::integer_sequence<uint32_t, kDepths...>) {
  ((data.record->depth == kDepths + 1 &&
    (data.classify_one = Kernel<kDepths + 1>::one, data.classify_array = Kernel<kDepths + 1>::array)),
   ...);
}

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
  data_->classify_array(*data_, segments, answers.data());
}

std::string_view Object::name() const noexcept { return data_->name; }
const ObjectRecord& Object::record() const noexcept { return *data_->record; }
bool Object::answers() const noexcept { return data_->classify_one != unclassified_one; }

Sidecar::Sidecar(std::unique_ptr<State> state) : state_(std::move(state)) {}
Sidecar::Sidecar(Sidecar&&) noexcept = default;
Sidecar& Sidecar::operator=(Sidecar&&) noexcept = default;
Sidecar::~Sidecar() = default;

Result<Sidecar> Sidecar::read(std::unique_ptr<State> state, Bytes bytes, const OpenOptions& options, const std::string& name) {
  std::vector<Finding> findings;
  auto contents = read_sidecar(bytes, options.check, findings);
  if (!contents) return first_error(name, findings);
  state->contents = std::move(*contents);
  for (const ObjectContents& object : state->contents.objects) {
    ObjectData data{make_grid_frame(object.record->box_min, object.record->box_max), object.tree, object.record,
                    object.name, nullptr, nullptr};
    const auto method = static_cast<Method>(object.record->method);
    if (method == Method::none || (options.proven_only && method == Method::sampled)) {
      data.classify_one = unclassified_one, data.classify_array = unclassified_array;
    } else {
      choose_kernels(data, std::make_integer_sequence<uint32_t, kMaxDepth>());
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

const SidecarContents& Sidecar::contents() const noexcept { return state_->contents; }

}  // namespace vcd
