// glTF 2.0 to triangles.
#pragma once

#include <vcd/baker/ingest.h>

#include <filesystem>
#include <string_view>

namespace vcd::baker {

// Reads .gltf and .glb; see ingest(). One SourceMesh a glTF mesh, in mesh space.
//
// Read: all three triangle modes, with or without indices; sparse and interleaved accessors;
// KHR_mesh_quantization; KHR_draco_mesh_compression; EXT_meshopt_compression and what is equal to it of
// KHR_meshopt_compression; buffers in the GLB, in data URIs and in files beside. Images are never looked for.
// No exception leaves.
Result<Ingested> ingest_gltf(const std::filesystem::path& path, std::string_view bytes, const IngestOptions& options);

}  // namespace vcd::baker
