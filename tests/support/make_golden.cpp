// make_golden FOLDER: the golden files: a file for each depth, whose trees are made up so that each has all that a file
// can hold and yet is small; one with every method; one with everything else that a file can say; one without objects;
// and the worked example of vcd-format.md. They were released with format 1.0 and are never made anew. This program
// shows how they came to be; later bake revisions give other bytes.
#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <random>

#include <vcd/format/tree_statistics.h>

#include "octree/dag.h"
#include "support/files.h"
#include "support/meshes.h"

namespace vcd::test {
using namespace baker;
namespace {

// A quarter of the top cells share three random subtrees, which are made of twelve bricks; the others are uniform.
TreeArrays golden_tree(uint32_t depth, uint32_t classes) {
  std::mt19937 random(depth);
  const auto below = [&](uint32_t n) { return static_cast<uint32_t>(random() % n); };
  std::vector<BrickWords> palette(12);
  for (BrickWords& brick : palette)
    for (uint32_t i = 0; i < 256; ++i) {
      // Depth 1 repeats every cell over two levels; else every other group of sixteen cells is of one class.
      const uint32_t group = (i >> 7 & 1) << 3 | (i >> 5 & 1) << 2 | (i >> 3 & 1) << 1 | (i >> 1 & 1);
      const uint32_t seed = static_cast<uint32_t>(&brick - palette.data()) * 16 + group;
      const uint32_t value = depth == 1 || group % 2 ? seed * 7 / 5 % classes : below(classes);
      brick[i / 16] |= value << (2 * (i % 16));
    }
  const TreeShape shape = tree_shape(depth);
  Subtree subtrees[3];
  for (Subtree& subtree : subtrees) {
    subtree.words = palette;
    subtree.bricks.resize(size_t{1} << (4 * (shape.levels - 2 - shape.top_levels)));
    for (uint32_t& brick : subtree.bricks) {
      brick = below(kUniformBlocks + 12);
      if (brick >= kUniformBlocks) brick += kDeeper - kUniformBlocks;
    }
  }
  DagBuilder builder(depth);
  for (uint32_t slot = 0; slot < shape.top_words(); ++slot) {
    Subtree uniform;
    uniform.bricks.assign(subtrees[0].bricks.size(), below(3));
    builder.append(below(4) == 0 ? subtrees[below(3)] : uniform);
  }
  return builder.take();
}

void write(const std::filesystem::path& path, std::vector<ObjectToWrite> objects, Storage storage,
           const std::map<std::string, std::string>& more = {}) {
  SidecarToWrite sidecar;
  sidecar.objects = std::move(objects);
  sidecar.storage = storage;
  sidecar.provenance = {{"baker", "make_golden"}, {"parts", "opaque"}, {"source", "none: the tree is made up"}};
  sidecar.provenance.insert(more.begin(), more.end());
  const auto written = write_sidecar(path, sidecar);
  std::printf("%s: %s\n", path.c_str(), written ? std::to_string(*written).c_str() : written.error().message.c_str());
}

// All four classes.
void write_layout(const std::filesystem::path& folder, uint32_t depth) {
  const TreeArrays arrays = golden_tree(depth, kClasses);
  BakeOptions options = quick(2, 81);
  options.method = Method::hybrid;
  ObjectRecord record = must_bake(leaves(4), options).record;  // box, hash and counts of some mesh
  const TreeStatistics statistics = measure_tree(arrays.view());
  record.depth = static_cast<uint8_t>(depth);
  std::copy_n(statistics.cells.begin(), 3, record.cells);
  record.statistical_cells = statistics.cells[3];
  record.audit_lines[0] = 1000 * depth, record.audit_lines[1] = 500;
  record.audit_wrong[0] = depth / 2, record.audit_wrong[1] = depth;
  record.audit_bound_95 = 0.0125f;
  record.block_counts = arrays.view().block_counts;
  record.brick_count = arrays.view().brick_count;
  record.nodes_unfolded = statistics.nodes_unfolded;
  record.nodes_folded = statistics.nodes_folded;
  record.nodes_shared = statistics.nodes_shared;
  const Storage storage = depth == 3 || depth >= 5 ? Storage::zstd : Storage::raw;
  write(folder / ("depth" + std::to_string(depth) + ".vcd"), {{"made up", record, tree_pieces(arrays.view()), {}}},
        storage);
}

void write_methods(const std::filesystem::path& path) {
  std::vector<BakedObject> baked;
  for (Method method : {Method::none, Method::sampled, Method::proven, Method::hybrid})
    for (SourceMesh mesh : {sphere(6, 8), triangle()}) {
      BakeOptions options = quick(3, 81);
      options.method = method;
      options.seed = 0xFEDCBA9876543210;
      baked.push_back(must_bake(std::move(mesh), options));
    }
  std::vector<ObjectToWrite> objects;
  for (const BakedObject& object : baked) objects.push_back(object.to_write());
  write(path, std::move(objects), Storage::zstd);
}

// Names, embedded geometry, clearance, a hierarchy of two levels, parts that were left out and a shift; and the last
// object alone.
void write_several(const std::filesystem::path& several, const std::filesystem::path& example) {
  BakeOptions options = quick(2, 81);
  options.seed = 0xFEDCBA9876543210;
  options.embed_geometry = true;
  std::vector<BakedObject> baked;
  for (SourceMesh mesh : {sphere(12, 16), leaves(4), leaves(5), triangle()})
    baked.push_back(must_bake(std::move(mesh), options));
  const std::string_view names[] = {"", "Ähre \"im\" Wind\n", "twice", "twice"};
  std::vector<ObjectToWrite> objects;
  for (uint32_t i = 0; i < baked.size(); ++i) {
    objects.push_back(baked[i].to_write());
    objects.back().name = names[i];
    objects.back().record.source_index = 10 * i;
  }
  objects[1].record.flags = kPartsLeftOut;
  std::ranges::copy(std::array{500000.0, 4649776.25, -0.1}, objects[2].record.shift);
  write(several, objects, Storage::raw, {{"left-out", "mesh 10, primitive 1: its alphaMode is BLEND\n"}});
  write(example, {objects.back()}, Storage::raw);
}

// Horizons of a closed mesh, without cells.
void write_horizons(const std::filesystem::path& path) {
  BakeOptions options;
  options.method = Method::none, options.horizons = true;
  const BakedObject baked = must_bake(sphere(6, 8), options);
  write(path, {baked.to_write()}, Storage::raw);
}

}  // namespace
}  // namespace vcd::test

int main(int argc, char** argv) {
  using namespace vcd;
  using namespace vcd::test;
  if (argc != 2) return 1;
  for (uint32_t depth = 1; depth <= kMaxDepth; ++depth) write_layout(argv[1], depth);
  const std::filesystem::path folder = argv[1];
  write_methods(folder / "methods.vcd");
  write_several(folder / "several.vcd", folder / "example.vcd");
  write_horizons(folder / "horizons.vcd");
  write(folder / "none.vcd", {}, Storage::raw);
}
