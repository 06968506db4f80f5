#include <vcd/runtime/sidecar_store.h>

#include <algorithm>
#include <deque>
#include <map>
#include <mutex>
#include <new>
#include <string>
#include <system_error>
#include <utility>

#include <vcd/format/contents.h>
#include <vcd/format/file_bytes.h>

namespace vcd {
namespace {

namespace fs = std::filesystem;

// Sorted, so that the order does not depend on the file system.
Result<std::vector<fs::path>> sidecars_below(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  fs::recursive_directory_iterator at(folder, error), end;
  for (; !error && at != end; at.increment(error))
    if (at->path().extension() == ".vcd" && at->is_regular_file(error)) files.push_back(at->path());
  if (error) return Error{ErrorCode::io, folder.string() + ": " + error.message()};
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

struct SidecarStore::State {
  struct StoredFile {
    explicit StoredFile(const fs::path& at) : path(at) {}

    fs::path path;
    std::once_flag once;
    std::optional<Result<Sidecar>> opened;
  };

  OpenOptions options;
  std::deque<StoredFile> files;  // of which one is opened does not move
  std::map<GeometryHash, StoredFile*> by_geometry;
  std::vector<Error> passed_over;

  void add(const fs::path& path) {
    const auto bytes = options.load == Load::map ? FileBytes::map(path) : FileBytes::copy(path);
    auto geometries = bytes ? read_geometry_hashes(bytes->bytes(), path.string()) : bytes.error();
    if (!geometries) {
      passed_over.push_back(std::move(geometries.error()));
      return;
    }
    files.emplace_back(path);
    for (const GeometryHash& geometry : *geometries) by_geometry.emplace(geometry, &files.back());
  }
};

SidecarStore::SidecarStore(std::unique_ptr<State> state) : state_(std::move(state)) {}
SidecarStore::SidecarStore(SidecarStore&&) noexcept = default;
SidecarStore& SidecarStore::operator=(SidecarStore&&) noexcept = default;
SidecarStore::~SidecarStore() = default;

Result<SidecarStore> SidecarStore::open(std::span<const fs::path> folders, const OpenOptions& options) {
  try {
    auto state = std::make_unique<State>();
    state->options = options;
    for (const fs::path& folder : folders) {
      const auto files = sidecars_below(folder);
      if (!files) return files.error();
      for (const fs::path& file : *files) state->add(file);
    }
    return SidecarStore(std::move(state));
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::runtime, "sidecar store: out of memory"};
  }
}

Result<std::optional<Object>> SidecarStore::find(const GeometryHash& geometry) const {
  const auto found = state_->by_geometry.find(geometry);
  if (found == state_->by_geometry.end()) return std::optional<Object>();
  State::StoredFile& file = *found->second;
  std::call_once(file.once, [&] { file.opened = Sidecar::open(file.path, state_->options); });
  if (!*file.opened) return file.opened->error();
  const std::optional<Object> object = file.opened->value().find(geometry);
  if (!object) return Error{ErrorCode::io, file.path.string() + ": replaced since the store was opened"};
  return object;
}

size_t SidecarStore::size() const noexcept { return state_->by_geometry.size(); }
const std::vector<Error>& SidecarStore::passed_over() const noexcept { return state_->passed_over; }

}  // namespace vcd
