// One sidecar: the file, byte by byte; its meshes; its answers.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include <vcd/baker/audit.h>
#include <vcd/baker/ingest.h>
#include <vcd/baker/prepare.h>

#include <vcd/verify/library.h>
#include <vcd/verify/outcome.h>

namespace vcd::verify {

struct CheckOptions {
  std::string against;             // a mesh file; or
  Library* library = nullptr;      // a library; or neither: embedded geometry is all there is
  baker::IngestOptions ingest;     // of what no sidecar says: files_outside
  std::optional<Segment> segment;  // asked and traced instead of an audit
  baker::AuditOptions audit;
  double max_wrong = -1;  // share of wrong answers that is accepted; negative: by method
  // Asked often, from many threads; true ends the check as not verified.
  std::function<bool()> stop = [] { return false; };
};

// Throws nothing. Safe on any bytes. Any number at a time; each holds its sidecar's bytes, its trees and one asset's
// meshes in memory.
Outcome check_sidecar(const library::FoundFile& file, const CheckOptions& options);

// A sidecar in memory against meshes in memory: the same checks, without a file and without another process. Embedded
// geometry is not looked at; options.against and options.library are not used. Throws nothing. Safe on any bytes.
//
// sidecar:  the bytes of a sidecar file, aligned to 64 bytes, as Sidecar::open_buffer takes them
// meshes:   each object needs one with its geometry hash, else it is stale; prepare() makes them
// name:     of the sidecar, in the outcome
Outcome check_bytes(Bytes sidecar, std::span<const baker::PreparedMesh> meshes, const CheckOptions& options,
                    const std::filesystem::path& name = "sidecar");

}  // namespace vcd::verify
