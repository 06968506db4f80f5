// What became of one file: of a sidecar, of an asset of the library, or of an input that names neither. Every report is
// written from these.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/describe.h"
#include "findings.h"

namespace vcd::verify {

using GeometryHash = std::array<uint8_t, 16>;

struct Issue {
  const FindingInfo* info;
  Severity severity;                // info's, unless --allow makes it a warning
  ErrorCode code;                   // what it makes of the exit code if it is an error
  std::string place;                // within the file: an object, a mesh; or empty
  std::string detail;               // for a person; may be empty
  std::optional<Finding> in_bytes;  // what the reader found, if it did

  std::string text() const;  // without the name of the file; one line of UTF-8, as are place and detail
};

enum class Subject : uint8_t { input, sidecar, asset };

struct Outcome {
  Subject subject = Subject::sidecar;
  std::filesystem::path path = {};
  std::vector<Issue> issues = {};
  Json details = {};      // "objects" of a sidecar, "meshes" of an asset
  std::string text = {};  // what a person wants to see of a sound file, too: audits
  uint64_t contradictions_seen = 0, contradictions_listed = 0;

  std::vector<GeometryHash> geometries = {};  // of the objects, if the sidecar could be read
  std::vector<size_t> stale_against = {};     // assets that have its name and another geometry

  void add(const Finding& finding);
  void add(IssueId id, ErrorCode code, const std::string& place, const std::string& detail);
  bool has(IssueId id) const;
  bool failed() const { return exit_code() != 0; }
  int exit_code() const;  // of the first error
};

// The message without "PATH: " in front of it.
std::string reason(const Error& error, const std::filesystem::path& path);

// {"file", "findings", the details, "errors", "exit_code"}
Json describe_outcome(const Outcome& outcome);

}  // namespace vcd::verify
