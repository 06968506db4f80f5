// One sidecar: the file, byte by byte; its meshes; its answers.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include <vcd/baker/audit.h>
#include <vcd/baker/ingest.h>

#include "library.h"
#include "outcome.h"

namespace vcd::verify {

struct CheckOptions {
  std::string against;             // a mesh file; or
  Library* library = nullptr;      // a library; or neither: embedded geometry is all there is
  IngestOptions ingest;            // of what no sidecar says: files_outside
  std::optional<Segment> segment;  // asked and traced instead of an audit
  baker::AuditOptions audit;
  double max_wrong = -1;       // share of wrong answers that is accepted; negative: by method
  std::function<bool()> stop;  // asked often, from many threads; true ends the check as not verified
};

// Throws nothing. Safe on any bytes. Any number at a time; each holds its sidecar's bytes, its trees and one asset's
// meshes in memory.
Outcome check_sidecar(const FoundFile& file, const CheckOptions& options);

}  // namespace vcd::verify
