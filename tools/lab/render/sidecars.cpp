#include "sidecars.h"

#include <algorithm>

#include "common/describe.h"

namespace vcd::render {

using namespace baker;
using namespace tools;

Result<WorldSidecars> open_sidecars(const World& world, const std::vector<std::string>& paths,
                                    const OpenOptions& options) {
  WorldSidecars sidecars;
  for (const std::string& path : paths) {
    auto sidecar = Sidecar::open(path, options);
    if (!sidecar) return sidecar.error();
    sidecars.files.push_back(std::move(*sidecar));
  }
  for (const WorldObject& object : world.objects) {
    std::optional<Object> found;
    for (const Sidecar& sidecar : sidecars.files)
      if (!found) found = sidecar.find(object.mesh.geometry_hash);
    if (!found) {
      std::string names;
      for (const std::string& path : paths) names += (names.empty() ? "" : ", ") + path;
      return Error{ErrorCode::stale, names + ": stale, or of another mesh: nothing in it has the geometry hash " +
                                         hex(object.mesh.geometry_hash) + " of " + object.source + " " +
                                         printable(object.mesh.name)};
    }
    sidecars.objects.push_back(*found);
  }
  return sidecars;
}

Result<WorldBake> bake_world(const World& world, const BakeOptions& options, const std::filesystem::path& path,
                             const std::function<void(const WorldObject&, const BakeProgress&)>& progress) {
  std::vector<BakedObject> baked;
  WorldBake sum;
  for (const WorldObject& object : world.objects) {
    BakeOptions here = options;
    here.progress = [&](const BakeProgress& p) { progress(object, p); };
    here.audit_lines = kQuickAuditLines;
    auto result = bake(object.mesh, here);
    if (!result) return Error{result.error().code, object.source + ": " + result.error().message};
    sum.seconds += result->seconds;
    sum.rays += result->rays;
    sum.depth = std::max(sum.depth, uint32_t{result->record.depth});
    baked.push_back(std::move(*result));
  }
  const auto written = write_world(world, baked, path, options.stop);
  if (!written) return written.error();
  sum.file_bytes = *written;
  return sum;
}

Result<uint64_t> write_world(const World& world, const std::vector<BakedObject>& baked,
                             const std::filesystem::path& path, const std::function<bool()>& stop) {
  SidecarToWrite file;
  for (const BakedObject& object : baked) file.objects.push_back(object.to_write());
  file.provenance = {{"baker", "vcd " VCD_VERSION}, {"source", world.name}};
  file.stop = stop;
  return write_sidecar(path, file);
}

}  // namespace vcd::render
