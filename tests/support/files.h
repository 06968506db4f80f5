// Temporary folders, whole files, and sidecars in memory.
#pragma once

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <vcd/baker/audit.h>
#include <vcd/baker/bake.h>
#include <vcd/format/line_cell.h>
#include <vcd/format/tree.h>
#include <vcd/writer/writer.h>

namespace vcd::test {

// Sanitizers make everything five to ten times slower: tests whose work grows with depth take a level less.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)  // GCC
inline constexpr bool kSanitized = true;
#elif defined(__has_feature)  // Clang
inline constexpr bool kSanitized = __has_feature(address_sanitizer) || __has_feature(thread_sanitizer);
#else
inline constexpr bool kSanitized = false;
#endif
// Why some tests are skipped with sanitizers.
inline constexpr const char* kOnceIsEnough = "long, and about figures: shorter tests run the same code";

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::random_device random;
    path_ =
        std::filesystem::temp_directory_path() / ("vcd-test-" + std::to_string(random()) + std::to_string(random()));
    std::filesystem::create_directories(path_);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline std::vector<std::byte> read_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::vector<char> chars((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  std::vector<std::byte> bytes(chars.size());
  if (!bytes.empty()) std::memcpy(bytes.data(), chars.data(), chars.size());
  return bytes;
}

inline void write_file(const std::filesystem::path& path, Bytes bytes) {
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

inline baker::BakedObject must_bake(baker::SourceMesh mesh, const baker::BakeOptions& options) {
  const auto prepared = baker::prepare(std::move(mesh));
  auto baked = bake(*prepared, options);
  if (!baked) throw std::runtime_error(baked.error().message);
  return std::move(*baked);
}

inline std::vector<std::byte> sidecar_bytes(const std::vector<const baker::BakedObject*>& objects,
                                            Storage storage = Storage::raw) {
  SidecarToWrite contents;
  contents.storage = storage;
  contents.provenance = {{"baker", "test"}, {"parts", "opaque"}};
  for (const baker::BakedObject* object : objects) contents.objects.push_back(object->to_write());
  const auto bytes = vcd::sidecar_bytes(contents);
  if (!bytes) throw std::runtime_error(bytes.error().message);
  return {bytes->data.get(), bytes->data.get() + bytes->size};
}

// A tree in memory as an audit asks it; the tree outlives the function.
inline baker::Answers answers_of(const ObjectRecord& record, const TreeView& tree) {
  return [frame = make_grid_frame(record.box_min, record.box_max), tree](std::span<const Segment> segments,
                                                                         std::span<Visibility> answers) {
    for (size_t i = 0; i < segments.size(); ++i) answers[i] = classify(frame, tree, tree.shape, segments[i]);
  };
}

inline baker::Answers no_answers() {
  return [](std::span<const Segment>, std::span<Visibility> answers) {
    std::ranges::fill(answers, Visibility::unclassified);
  };
}

inline baker::BakeOptions proven(uint32_t depth) {
  baker::BakeOptions options;
  options.method = Method::proven;
  options.depth = depth;
  return options;
}

inline baker::BakeOptions quick(uint32_t depth, uint32_t samples = 16) {
  baker::BakeOptions options;
  options.method = Method::sampled;
  options.depth = depth;
  options.samples = samples;
  return options;
}

}  // namespace vcd::test
