#include "cost.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

namespace vcd {
namespace {

namespace fs = std::filesystem;

// Bytes of a file a triangle: common ones, on the small side.
double bytes_a_triangle(const fs::path& path) {
  static const std::map<std::string, double> kBytes = {{".obj", 30}, {".ply", 19},  {".stl", 50}, {".off", 28},
                                                       {".glb", 20}, {".gltf", 25}, {".drc", 3}};
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  const auto known = kBytes.find(extension);
  return known == kBytes.end() ? 20 : known->second;
}

double size_of(const fs::path& path) {
  std::error_code error;
  const uintmax_t size = fs::file_size(path, error);
  return error ? 0 : static_cast<double>(size);
}

// Seconds of classifying one object at a depth with one thread; a mesh of ten thousand triangles.
double bake_seconds(uint32_t depth) { return 0.0011 * std::pow(7.0, depth); }

}  // namespace

Cost guess_cost(const Asset& asset) {
  double bytes = size_of(asset.input);
  if (asset.input.extension() == ".gltf") bytes += size_of(fs::path(asset.input).replace_extension(".bin"));
  const double triangles = bytes / bytes_a_triangle(asset.input);
  const BakeOptions options = asset.settings.bake_options();
  const uint32_t depth = options.depth ? options.depth : triangles < 500 ? 2 : 5;
  double bake = bake_seconds(depth) * std::cbrt(std::max(triangles, 100.0) / 1e4);
  if (options.depth == 0) bake += 1;  // the probe
  if (options.budget_seconds > 0) bake = std::min(bake, options.budget_seconds);
  const double audit = static_cast<double>(asset.settings.audit_lines) * 1.2e-6;
  const double tree_bytes = std::min(15 * std::pow(16.0, depth) / 4, 4e9);
  return {0.02 + 4e-6 * triangles + bake + audit,
          static_cast<uint64_t>(96e6 + 500 * triangles + 3 * bytes + 0.3 * tree_bytes)};
}

}  // namespace vcd
