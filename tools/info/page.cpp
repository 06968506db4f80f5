#include "page.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <new>
#include <span>

#include <zlib.h>

#include <vcd/baker/mesh_health.h>
#include <vcd/writer/writer.h>

#include "common/describe.h"
#include "common/health_report.h"
#include "common/paths.h"
#include "info/object_mesh.h"
#include "info/page_files.h"
#include "info/surface.h"
#include "info/views.h"

namespace vcd::tools {

using namespace baker;
namespace {

constexpr uint32_t kViewPixels = 224;

// All numbers of the page, one array after another, each at a multiple of 4.
class Arrays {
 public:
  template <class T>
  Json add(const std::vector<T>& array) {
    return add({std::as_bytes(std::span(array))});
  }
  // [first byte, bytes]
  Json add(const std::vector<Bytes>& pieces) {
    const size_t first = bytes_.size();
    for (const Bytes piece : pieces) bytes_.append(reinterpret_cast<const char*>(piece.data()), piece.size());
    const Json place = {first, bytes_.size() - first};
    bytes_.resize((bytes_.size() + 3) & ~size_t{3});
    return place;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

std::string base64(const std::string& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t word = 0;
    for (size_t k = 0; k < 3; ++k) word = word << 8 | (i + k < bytes.size() ? static_cast<uint8_t>(bytes[i + k]) : 0);
    for (size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? kDigits[word >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string deflated(const std::string& bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::string out(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                static_cast<uLong>(bytes.size()), Z_DEFAULT_COMPRESSION) != Z_OK)
    throw std::bad_alloc();
  out.resize(size);
  return out;
}

// In HTML outside tags, and in JSON inside a script.
std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : std::string(1, c);
  return out;
}
std::string in_script(const std::string& json) {
  std::string out;
  for (const char c : json) out += c == '<' ? "\\u003c" : std::string(1, c);
  return out;
}

Result<Json> views_json(const ObjectContents& object) {
  Json views = Json::array();
  for (const View& view : views_of(object, kViewPixels)) {
    const auto png = png_of(view.picture);
    if (!png) return png.error();
    views.push_back({{"azimuth", view.azimuth},
                     {"elevation", view.elevation},
                     {"shares", view.shares},
                     {"png", "data:image/png;base64," + base64(*png)}});
  }
  return views;
}

// The tree's bytes; where its tables of words begin in them and how many levels a word of each resolves; where its
// bricks begin.
Json tree_json(const ObjectContents& object, Arrays& arrays, size_t& tree_bytes) {
  if (object.record->method == static_cast<uint8_t>(Method::none)) return nullptr;
  std::vector<Bytes> pieces = tree_pieces(object.tree);
  std::erase_if(pieces, [](Bytes piece) { return piece.empty(); });
  size_t size = 0;
  for (const Bytes piece : pieces) size += piece.size();
  if (tree_bytes + size > kMostTreeBytes) return nullptr;
  tree_bytes += size;
  const TreeShape shape = object.tree.shape;
  Json tables = {{0, shape.top_levels}};
  size_t at = pieces[0].size();
  for (size_t i = 1; i + 1 < pieces.size(); ++i) {  // blocks of one level each; the last are bricks
    tables.push_back({at, 1});
    at += pieces[i].size();
  }
  return {{"place", arrays.add(pieces)}, {"tables", tables}, {"bricks", at}};
}

Json horizons_json(const ObjectMesh& mesh, const DrawnSurface& surface, Arrays& arrays) {
  if (mesh.horizons.empty()) return nullptr;
  std::vector<uint8_t> bytes;  // 255: none
  for (const uint32_t t : surface.source)
    bytes.push_back(mesh.horizons[t] < 0 ? 255 : static_cast<uint8_t>(std::lround(254 * mesh.horizons[t])));
  return arrays.add(bytes);
}

std::string facts_of(const ObjectContents& object, const PreparedMesh& mesh) {
  return object_summary(*object.record) + hierarchy_summary(*object.record, object.hierarchy) +
         horizon_summary(object.horizon) + health_summary(mesh_health(mesh.positions.size(), mesh.triangles));
}

Result<Json> object_json(const ObjectContents& object, const ObjectMesh& mesh, size_t most_triangles, Arrays& arrays,
                         size_t& tree_bytes, const PageOptions& options) {
  const DrawnSurface surface = drawn_surface(mesh.mesh, most_triangles);
  const auto shares = surface_shares(object, mesh.mesh, surface, options.stop);
  if (!shares) return shares.error();
  const ObjectRecord& record = *object.record;
  Json whys = Json::array();
  for (const auto& why : shares->why) whys.push_back(arrays.add(why));
  return Json{{"name", object.name},
              {"source_index", record.source_index},
              {"facts", facts_of(object, mesh.mesh)},
              {"method", method_name(static_cast<Method>(record.method))},
              {"depth", record.depth},
              {"box_min", record.box_min},
              {"box_max", record.box_max},
              {"mesh_source", mesh.source},
              {"triangles", mesh.mesh.triangles.size()},
              {"drawn", surface.triangles.size()},
              {"thinned", surface.thinned},
              {"positions", arrays.add(surface.positions)},
              {"indices", arrays.add(surface.triangles)},
              {"answered", arrays.add(shares->answered)},
              {"proven", arrays.add(shares->proven)},
              {"why", whys},
              {"horizons", horizons_json(mesh, surface, arrays)},
              {"tree", tree_json(object, arrays, tree_bytes)}};
}

// Of an object with so many of all triangles. Where they are too many, half of what may be drawn is shared out by size
// and half equally, so that small objects stay whole.
size_t most_drawn(size_t triangles, size_t all, size_t objects) {
  const size_t equal_share = kMostDrawnTriangles / objects;
  if (all <= kMostDrawnTriangles) return triangles + equal_share;  // room to cut
  const double of_all = static_cast<double>(triangles) / static_cast<double>(all);
  return equal_share / 2 + static_cast<size_t>(of_all * kMostDrawnTriangles / 2) + 1;
}

// The template, with each {{NAME}} replaced. Nothing is replaced in what was put in.
std::string filled(std::string_view html, const std::vector<std::pair<std::string_view, std::string_view>>& parts) {
  std::string page;
  for (size_t begin; (begin = html.find("{{")) != html.npos;) {
    const size_t end = html.find("}}", begin);
    const std::string_view name = html.substr(begin + 2, end - begin - 2);
    page += html.substr(0, begin);
    page += std::ranges::find(parts, name, &std::pair<std::string_view, std::string_view>::first)->second;
    html.remove_prefix(end + 2);
  }
  return page += html;
}

}  // namespace

Result<std::string> page_of(const std::string& path, const SidecarContents& sidecar, const PageOptions& options) try {
  if (sidecar.objects.empty()) return Error{ErrorCode::usage, shown(path) + ": has no objects to show"};
  const auto meshes = meshes_of(path, sidecar, options.mesh_file, options.ingest);
  if (!meshes) return meshes.error();
  size_t all = 0;
  for (const ObjectMesh& mesh : *meshes) all += mesh.mesh.triangles.size();
  Arrays arrays;
  size_t tree_bytes = 0;
  Json objects = Json::array();
  for (size_t i = 0; i < meshes->size(); ++i) {
    const ObjectMesh& mesh = (*meshes)[i];
    if (options.stop && options.stop()) return Error{ErrorCode::runtime, shown(path) + ": interrupted"};
    const size_t most = most_drawn(mesh.mesh.triangles.size(), all, meshes->size());
    auto object = object_json(sidecar.objects[i], mesh, most, arrays, tree_bytes, options);
    if (!object) return Error{object.error().code, shown(path) + ": " + object.error().message};
    auto views = i < kMostPictured ? views_json(sidecar.objects[i]) : Result<Json>(Json::array());
    if (!views) return Error{views.error().code, shown(path) + ": " + views.error().message};
    (*object)["views"] = std::move(*views);
    objects.push_back(std::move(*object));
  }
  Json provenance = Json::object();
  for (const auto& [key, value] : sidecar.provenance) provenance[std::string(key)] = value;
  const std::string name = shown(std::filesystem::path(path).filename());
  const Json data = {{"file", name},
                     {"version", VCD_VERSION},
                     {"bytes", sidecar.header->file_size},
                     {"class_colours", kClassColours},
                     {"objects", objects},
                     {"provenance", provenance}};
  return filled(kPageHtml, {{"title", escaped(name)},
                            {"css", kPageCss},
                            {"three", kThreeJs},
                            {"controls", kOrbitControlsJs},
                            {"data", in_script(json_text(data))},
                            {"arrays", base64(deflated(arrays.bytes()))},
                            {"look_up", kLookUpJs},
                            {"scene", kSceneJs},
                            {"page", kPageJs}});
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::runtime, shown(path) + ": out of memory"};
}

}  // namespace vcd::tools
