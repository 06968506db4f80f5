// The bytes behind buffers and buffer views, fetched when they are first asked for.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include <vcd/baker/source.h>

#include "ingest/gltf_document.h"

namespace vcd::baker {

struct GltfView {
  std::span<const uint8_t> bytes;  // lives as long as its GltfBuffers
  std::optional<uint32_t> stride;  // byteStride, 1 to 252; nothing where it is absent or 0
};

// Fetching late means that a buffer which only textures or animations use may be missing, and that the
// placeholder behind a compressed view, which holds no data, is never touched.
class GltfBuffers {
 public:
  // files_outside: may URIs lead out of the document's folder?
  explicit GltfBuffers(const GltfDocument& document, bool files_outside = false)
      : document_(document), files_outside_(files_outside) {}
  GltfBuffers(const GltfBuffers&) = delete;
  GltfBuffers& operator=(const GltfBuffers&) = delete;

  // Throws GltfFailure: invalid_file (no such view, a range outside its buffer, broken compression), io (a
  // file that cannot be read), unsupported (a URI of another scheme or out of the folder, an
  // unknown compression).
  GltfView view(uint32_t index);

  const std::vector<SourceFile>& files() const { return files_; }  // that were read so far, in that order

 private:
  std::span<const uint8_t> buffer(uint32_t index);
  std::string load_from_uri(const GltfElement<GltfBufferSource>& buffer);
  // The bytes that byteOffset and byteLength of a view, or of its compression extension, select.
  std::span<const uint8_t> range(uint32_t buffer, uint64_t offset, uint64_t length, const std::string& place);
  std::span<const uint8_t> decompressed(uint32_t index, const GltfElement<tinygltf::BufferView>& view,
                                        const GltfElement<tinygltf::Value>& extension);

  const GltfDocument& document_;
  bool files_outside_;
  std::vector<SourceFile> files_;
  std::map<uint32_t, std::string> loaded_;                 // by buffer; a map keeps its elements in place
  std::map<uint32_t, std::vector<uint8_t>> decompressed_;  // by view
};

}  // namespace vcd::baker
