#include <vcd/library/cost.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <string>
#include <string_view>

#include <vcd/format/demand.h>
#include <vcd/library/light_demand.h>
#include "common/paths.h"

namespace vcd::library {

using namespace baker;
namespace {

using namespace tools;

namespace fs = std::filesystem;

// Bytes of a file a triangle: common ones, on the small side.
double bytes_a_triangle(const fs::path& path) {
  static const std::map<std::string, double> kBytes = {{"obj", 30}, {"ply", 19},  {"stl", 50}, {"off", 28},
                                                       {"glb", 20}, {"gltf", 25}, {"drc", 3}};
  const auto known = kBytes.find(extension_of(path));
  return known == kBytes.end() ? 20 : known->second;
}

// Meshes of a glTF file, each an object to be baked: how often the start of its JSON says "primitives".
double objects_in(const fs::path& path) {
  constexpr uint32_t kMost = 1 << 20;
  const std::string extension = extension_of(path);
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return 1;  // a pipe, say, at which one would wait
  uint32_t length = kMost;
  std::ifstream file(path, std::ios::binary);
  if (extension == "glb") {
    std::array<char, 20> header{};  // the file's, and that of its first chunk, which is the JSON
    file.read(header.data(), header.size());
    std::memcpy(&length, header.data() + 12, sizeof length);
  } else if (extension != "gltf") {
    return 1;
  }
  std::string start(std::min(length, kMost), '\0');
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<size_t>(file.gcount()));
  constexpr std::string_view kMesh = "\"primitives\"";
  double objects = 0;
  for (size_t at = 0; (at = start.find(kMesh, at)) != std::string::npos; at += kMesh.size()) ++objects;
  return std::max(objects, 1.0);
}

double size_of(const fs::path& path) {
  std::error_code error;
  const uintmax_t size = fs::file_size(path, error);
  return error ? 0 : static_cast<double>(size);
}

// Of what is spent on one object at a depth, with one thread: fitted to processor times of twenty meshes of 12 to
// 560,000 triangles at depths 2 to 5. Two of three are within a factor of 1.6.
double bake_seconds(uint32_t depth, double triangles) {
  return 0.0008 * std::pow(7.0, depth) * std::cbrt(std::max(triangles, 30.0) / 1e4);
}

double demand_bytes(const BakeSettings& settings) {
  if (!settings.demand.path.empty()) return size_of(settings.demand.path);
  return static_cast<double>(kLightSegments * sizeof(AskedSegment));
}

}  // namespace

Cost guess_cost(const Asset& asset) {
  double bytes = size_of(asset.input);
  if (extension_of(asset.input) == "gltf") bytes += size_of(fs::path(asset.input).replace_extension(".bin"));
  const double triangles = std::exp2(2 * asset.settings.subdivide) * bytes / bytes_a_triangle(asset.input);
  const double objects = objects_in(asset.input), of_one = triangles / objects;
  const BakeOptions options = asset.settings.bake_options();
  // Without a depth: most end at 5, by the default budget of bytes; those of few triangles at none, and that at once.
  constexpr double kFew = 64;
  // For a demand some cells are deep, and most are coarse: about as much as all at 5.
  const bool by_demand = asset.settings.for_a_demand();
  const uint32_t depth = options.depth && !by_demand ? options.depth : of_one < kFew ? 0 : 5;
  double bake = bake_seconds(depth, of_one);
  if (options.budget_seconds > 0) bake = std::min(bake, options.budget_seconds);
  const double audit = static_cast<double>(asset.settings.audit_lines) * 0.55e-6;
  const double tree_bytes = std::min(15 * std::pow(16.0, depth) / 4, 4e9);
  return {0.02 + 2.5e-6 * triangles + objects * (bake + audit),
          static_cast<uint64_t>(96e6 + 500 * triangles + 3 * bytes + 0.3 * tree_bytes +
                                (by_demand ? 4 * demand_bytes(asset.settings) : 0))};
}

}  // namespace vcd::library
