// A mesh file, ready to be traced as renderers trace it.
#pragma once

#include <array>
#include <string>

#include <vcd/baker/prepare.h>
#include <vcd/baker/tracer.h>
#include <vcd/format/contents.h>

namespace vcd::bench {

struct TracedMesh {
  PreparedMesh mesh;
  Tracer tracer;

  // The mesh with that hash, or the first, ingested as the sidecar says (null: as by default). Errors: those of
  // load_meshes(); stale.
  static Result<TracedMesh> load(const std::string& path, const SidecarContents* sidecar,
                                 const std::array<uint8_t, 16>* hash);
};

}  // namespace vcd::bench
