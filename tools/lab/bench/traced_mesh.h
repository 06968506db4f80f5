// A mesh file, ready to be traced as renderers trace it.
#pragma once

#include <array>
#include <string>

#include <vcd/baker/ingest.h>
#include <vcd/baker/prepare.h>
#include <vcd/baker/tracer.h>
#include <vcd/format/contents.h>

namespace vcd::bench {

struct MeshToRead {
  std::string path;
  baker::IngestOptions ingest = {};
  bool quiet = false;  // no notes of what the file lacks
};

struct TracedMesh {
  baker::PreparedMesh mesh;
  baker::Tracer tracer;

  // The mesh with that hash, or the first. Errors: those of load_meshes(); stale.
  static Result<TracedMesh> load(const MeshToRead& file, const std::array<uint8_t, 16>* hash = nullptr);
};

}  // namespace vcd::bench
