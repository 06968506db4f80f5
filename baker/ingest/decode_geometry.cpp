#include <utility>

#include <vcd/baker/bake.h>

#include "draco_mesh.h"
#include "isolate.h"

namespace vcd::baker {

Result<SourceMesh> decode_geometry(Bytes bytes) {
  auto decoded = decode_draco({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
  if (!decoded) return decoded.error();
  SourceMesh mesh;
  mesh.positions = std::move(decoded->positions);
  mesh.triangles = std::move(decoded->triangles);
  return mesh;
}

Result<SourceMesh> decode_geometry_isolated(Bytes draco, const std::string& name) {
  auto decoded = run_isolated(name, {}, [&]() -> Result<Ingested> {
    auto mesh = decode_geometry(draco);
    if (!mesh) return Error{mesh.error().code, name + ": " + mesh.error().message};
    Ingested ingested;
    ingested.meshes.push_back(std::move(*mesh));
    return ingested;
  });
  if (!decoded) return decoded.error();
  return std::move(decoded->meshes.front());
}

}  // namespace vcd::baker
