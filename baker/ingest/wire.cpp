#include "ingest/wire.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <string>
#include <type_traits>
#include <vector>

#include "ingest/gltf_nodes.h"

namespace vcd::baker {
namespace {

// Layout: kBegin; 0 or the ErrorCode; for an Error its message, else the meshes (count; for each name,
// source_index, positions, triangles, shift, what was left out), the notes (count; strings), the placements and lights
// (arrays) and the sources (count; for each name, hash); kEnd. All numbers are uint64_t; a string or array is its
// count, then its items as they are in memory.
static_assert(sizeof(Placement) == 13 * 8, "no padding, whose bytes would be anyone's");
static_assert(sizeof(SceneLight) == 15 * 8, "likewise");
constexpr uint64_t kBegin = 0x6E49'7365'7364'6356;
constexpr uint64_t kEnd = 0x646E'4573'6873'656D;
constexpr size_t kChunk = size_t{1} << 30;  // one call moves at most 2 GiB

class Writer {
 public:
  explicit Writer(int file) : file_(file) {}

  bool bytes(const void* data, size_t size) {
    const char* from = static_cast<const char*>(data);
    while (size > 0) {
      const ssize_t written = ::write(file_, from, std::min(size, kChunk));
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) return false;
      from += written;
      size -= static_cast<size_t>(written);
    }
    return true;
  }
  bool number(uint64_t value) { return bytes(&value, sizeof(value)); }

  template <class Container>  // std::string or std::vector
  bool items(const Container& container) {
    static_assert(std::is_trivially_copyable_v<typename Container::value_type>);
    return number(container.size()) && bytes(container.data(), container.size() * sizeof(container[0]));
  }

 private:
  int file_;
};

class WireReader {
 public:
  WireReader(int file, uint64_t size) : file_(file), remaining_(size) {}

  uint64_t remaining() const { return remaining_; }

  bool bytes(void* data, size_t size) {
    if (size > remaining_) return false;
    char* to = static_cast<char*>(data);
    while (size > 0) {
      const ssize_t got = ::pread(file_, to, std::min(size, kChunk), offset_);
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return false;
      to += got;
      offset_ += got;
      size -= static_cast<size_t>(got);
      remaining_ -= static_cast<uint64_t>(got);
    }
    return true;
  }
  bool number(uint64_t& value) { return bytes(&value, sizeof(value)); }

  // A count of items, each of which takes `least_size` bytes or more.
  bool count(uint64_t& value, size_t least_size) { return number(value) && value <= remaining_ / least_size; }

  template <class Container>
  bool items(Container& container) {
    static_assert(std::is_trivially_copyable_v<typename Container::value_type>);
    uint64_t size = 0;
    if (!count(size, sizeof(container[0]))) return false;
    container.resize(size);
    return bytes(container.data(), size * sizeof(container[0]));
  }

 private:
  int file_;
  off_t offset_ = 0;
  uint64_t remaining_;
};

bool write_ingested(Writer& writer, const Ingested& ingested) {
  bool ok = writer.number(ingested.meshes.size());
  for (const SourceMesh& mesh : ingested.meshes) {
    ok = ok && writer.items(mesh.name) && writer.number(mesh.source_index) && writer.items(mesh.positions) &&
         writer.items(mesh.triangles) && writer.bytes(mesh.shift.data(), sizeof mesh.shift) &&
         writer.number(mesh.left_out.not_opaque) && writer.number(mesh.left_out.deforming);
  }
  ok = ok && writer.number(ingested.notes.size());
  for (const std::string& note : ingested.notes) ok = ok && writer.items(note);
  ok = ok && writer.items(ingested.placements) && writer.items(ingested.lights) &&
       writer.number(ingested.sources.size());
  for (const SourceFile& source : ingested.sources)
    ok = ok && writer.items(source.name) && writer.bytes(source.hash.data(), source.hash.size());
  return ok;
}

bool is_sound(const SceneLight& light) {
  const auto finite = [](const SceneLight::Vector& v) {
    return std::ranges::all_of(v, [](double x) { return std::isfinite(x); });
  };
  return light.shape <= SceneLight::Shape::sky && finite(light.position) && finite(light.direction) &&
         std::isfinite(light.cone_cosine) && std::isfinite(light.range) &&
         std::ranges::all_of(light.half_edges, finite);
}

bool read_ingested(WireReader& reader, Ingested& ingested) {
  constexpr size_t kLeastMesh = 9 * sizeof(uint64_t);
  uint64_t mesh_count = 0;
  if (!reader.count(mesh_count, kLeastMesh)) return false;
  for (uint64_t i = 0; i < mesh_count; ++i) {
    SourceMesh mesh;
    uint64_t source_index = 0;
    if (!reader.items(mesh.name) || !reader.number(source_index) || source_index > UINT32_MAX ||
        !reader.items(mesh.positions) || !reader.items(mesh.triangles) ||
        !reader.bytes(mesh.shift.data(), sizeof mesh.shift)) {
      return false;
    }
    for (uint32_t* count : {&mesh.left_out.not_opaque, &mesh.left_out.deforming}) {
      uint64_t value = 0;
      if (!reader.number(value) || value > UINT32_MAX) return false;
      *count = static_cast<uint32_t>(value);
    }
    mesh.source_index = static_cast<uint32_t>(source_index);
    ingested.meshes.push_back(std::move(mesh));
  }
  uint64_t note_count = 0;
  if (!reader.count(note_count, sizeof(uint64_t))) return false;
  for (uint64_t i = 0; i < note_count; ++i) {
    std::string note;
    if (!reader.items(note)) return false;
    ingested.notes.push_back(std::move(note));
  }
  if (!reader.items(ingested.placements)) return false;
  for (const Placement& placement : ingested.placements) {
    if (placement.mesh >= ingested.meshes.size() || why_not_invertible(placement.transform)) return false;
  }
  if (!reader.items(ingested.lights) || !std::ranges::all_of(ingested.lights, is_sound)) return false;
  uint64_t source_count = 0;
  if (!reader.count(source_count, sizeof(uint64_t) + sizeof(ContentHash))) return false;
  for (uint64_t i = 0; i < source_count; ++i) {
    SourceFile source;
    if (!reader.items(source.name) || !reader.bytes(source.hash.data(), source.hash.size())) return false;
    ingested.sources.push_back(std::move(source));
  }
  return true;
}

bool is_error_code(uint64_t code) {
  switch (static_cast<ErrorCode>(code)) {
    case ErrorCode::usage:
    case ErrorCode::io:
    case ErrorCode::invalid_file:
    case ErrorCode::runtime:
    case ErrorCode::unsupported:
    case ErrorCode::difference:
    case ErrorCode::stale: return code <= 8;
  }
  return false;
}

}  // namespace

bool write_result(int file, const Result<Ingested>& result) {
  Writer writer(file);
  bool ok = writer.number(kBegin);
  if (result) {
    ok = ok && writer.number(0) && write_ingested(writer, *result);
  } else {
    ok = ok && writer.number(static_cast<uint64_t>(result.error().code)) && writer.items(result.error().message);
  }
  return ok && writer.number(kEnd);
}

std::optional<Result<Ingested>> read_result(int file) {
  struct stat status;
  if (::fstat(file, &status) != 0 || status.st_size < 0) return std::nullopt;
  WireReader reader(file, static_cast<uint64_t>(status.st_size));
  uint64_t begin = 0;
  uint64_t code = 0;
  if (!reader.number(begin) || begin != kBegin || !reader.number(code)) return std::nullopt;
  Ingested ingested;
  std::string message;
  if (code != 0 && !is_error_code(code)) return std::nullopt;
  if (code == 0 ? !read_ingested(reader, ingested) : !reader.items(message)) return std::nullopt;
  uint64_t end = 0;
  if (!reader.number(end) || end != kEnd || reader.remaining() != 0) return std::nullopt;
  if (code != 0) return Result<Ingested>(Error{static_cast<ErrorCode>(code), std::move(message)});
  return Result<Ingested>(std::move(ingested));
}

}  // namespace vcd::baker
