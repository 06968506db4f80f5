#include "ingest/gltf.h"

#include <exception>
#include <new>
#include <string>
#include <utility>

#include "ingest/check.h"
#include "ingest/gltf_accessor.h"
#include "ingest/gltf_buffers.h"
#include "ingest/gltf_document.h"
#include "ingest/gltf_left_out.h"
#include "ingest/gltf_nodes.h"
#include "ingest/gltf_primitive.h"
#include "ingest/text.h"

namespace vcd::baker {

namespace {

class GltfReader {
 public:
  GltfReader(const std::filesystem::path& path, std::string_view bytes, const IngestOptions& options)
      : options_(options),
        document_(path, bytes),
        buffers_(document_, options.files_outside),
        skinned_(find_skinned_meshes(document_)) {
    for (const char* array : {"/meshes", "/nodes"}) document_.check(array);
  }

  Ingested read() {
    for (uint32_t index = 0; index < document_.model().meshes.size(); ++index) read_mesh(index);
    if (ingested_.meshes.empty()) fail_invalid("no triangle to bake: " + summary());
    if (options_.placements || options_.lights) place();
    ingested_.sources = buffers_.files();
    return std::move(ingested_);
  }

 private:
  // Nodes that are wrong cost no mesh: as without placements, all are given.
  void place() try { read_placements(document_, options_.lights, ingested_); } catch (const GltfFailure& failure) {
    ingested_.placements.clear(), ingested_.lights.clear();
    note("its nodes cannot be read, so that its meshes stand as they are: " + failure.error.message);
  }

  void read_mesh(uint32_t index) {
    const auto mesh = document_.mesh(index);
    const std::string place = mesh->name.empty() ? mesh.place : mesh.place + " " + quoted(mesh->name);
    const std::string pointer = "/meshes/" + std::to_string(index);
    GltfMeshBuilder builder(document_, buffers_, positions_);
    LeftOut left_out;
    for (size_t i = 0; i < mesh->primitives.size(); ++i) {
      const std::string primitive_place = place + ", primitive " + std::to_string(i);
      try {
        read_primitive(mesh->primitives[i], pointer + "/primitives/" + std::to_string(i), skinned_[index],
                       primitive_place, builder, left_out);
      } catch (const GltfFailure& failure) {
        fail_gltf(failure.error.code, primitive_place + ": " + failure.error.message);
      }
    }
    if (builder.triangle_count() == 0) {
      note(place + " omitted: no triangle is left of it");
      return;
    }
    ingested_.meshes.push_back(builder.take());
    ingested_.meshes.back().name = mesh->name;
    ingested_.meshes.back().source_index = index;
    ingested_.meshes.back().left_out = left_out;
  }

  void read_primitive(const tinygltf::Primitive& primitive, const std::string& pointer, bool skinned,
                      const std::string& place, GltfMeshBuilder& builder, LeftOut& of_mesh) {
    const GltfMode mode = mode_of(primitive);
    if (!makes_triangles(mode)) {
      ++points_or_lines_;
      note(place + (mode == GltfMode::points ? " passed over: points" : " passed over: lines"));
      return;
    }
    if (!primitive.attributes.contains("POSITION")) {
      ++without_position_;
      note(place + " passed over: it has no POSITION");
      return;
    }
    document_.check(pointer);
    if (!options_.treat_all_as_opaque) {
      if (const std::optional<GltfLeftOut> left_out = why_left_out(document_, primitive, skinned)) {
        const bool deforms = left_out->because == GltfLeftOutBecause::deforms;
        ++(deforms ? deforming_ : not_opaque_);
        ++(deforms ? of_mesh.deforming : of_mesh.not_opaque);
        note(place + " left out: " + left_out->reason);
        return;
      }
    }
    if (has_no_vertex(primitive)) {
      ++empty_;
      note(place + " passed over: it has no vertex");
      return;
    }
    for (const std::string& odd : builder.append(primitive)) note(place + ": " + odd);
  }

  // Of a Draco stream, the accessors only say what it ought to hold.
  bool has_no_vertex(const tinygltf::Primitive& primitive) const {
    if (primitive.extensions.contains("KHR_draco_mesh_compression")) return false;
    const auto is_empty = [&](int accessor) { return is_empty_accessor(document_, static_cast<uint32_t>(accessor)); };
    return is_empty(primitive.attributes.at("POSITION")) || (primitive.indices >= 0 && is_empty(primitive.indices));
  }

  std::string summary() const {
    std::string text = counted(document_.model().meshes.size(), "mesh", "meshes");
    const auto count = [&](size_t number, const char* what) {
      if (number > 0) text += ", " + counted(number, "primitive", "primitives") + " " + what;
    };
    count(not_opaque_, "left out as not opaque");
    count(deforming_, "left out as deforming");
    count(points_or_lines_, "passed over as points or lines");
    count(without_position_, "passed over without POSITION");
    count(empty_, "passed over without a vertex");
    return text;
  }

  void note(std::string sentence) { ingested_.notes.push_back(std::move(sentence)); }

  IngestOptions options_;
  GltfDocument document_;
  GltfBuffers buffers_;
  GltfPositions positions_{document_, buffers_};
  std::vector<bool> skinned_;
  Ingested ingested_;
  size_t not_opaque_ = 0;
  size_t deforming_ = 0;
  size_t points_or_lines_ = 0;
  size_t without_position_ = 0;
  size_t empty_ = 0;
};

}  // namespace

Result<Ingested> ingest_gltf(const std::filesystem::path& path, std::string_view bytes,
                             const IngestOptions& options) try {
  return GltfReader(path, bytes, options).read();
} catch (const GltfFailure& failure) {
  return file_error(path, failure.error.code, failure.error.message);
} catch (const std::bad_alloc&) {
  return file_error(path, ErrorCode::runtime, "out of memory while reading");
} catch (const std::exception& failure) {
  return file_error(path, ErrorCode::runtime, std::string("the parser failed: ") + failure.what());
}

}  // namespace vcd::baker
