// What became of one file: of a sidecar, of an asset of the library, or of an input that names neither. Every report is
// written from these.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <vcd/baker/audit.h>
#include <vcd/runtime/sidecar.h>

#include <vcd/verify/findings.h>

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

// What an object of a sidecar was asked, and how it stands to its mesh.
struct ObjectCheck {
  std::string name;   // in the file
  std::string place;  // for a person: its number and name
  std::optional<baker::AuditReport> audit;
  uint64_t contradictions_seen = 0;  // the audit lists the first of them
  double wrong_rate_at_least = 0, allowed_wrong_rate = 0;
  struct Replay {
    Visibility answer;
    bool is_blocked;  // by exact arithmetic
  };
  std::optional<Replay> replay;  // of the one segment that was asked instead
};

// A mesh of an asset of the library.
struct MeshCheck {
  uint32_t source_index;
  std::string name;
  GeometryHash geometry;
  bool has_sidecar;
};

enum class Subject : uint8_t { input, sidecar, asset };

struct Outcome {
  Subject subject = Subject::sidecar;
  std::filesystem::path path = {};
  std::vector<Issue> issues = {};
  std::vector<std::string> notes = {};    // what its mesh file has and its meshes have not, for a person; UTF-8
  std::vector<ObjectCheck> objects = {};  // of a sidecar, if it could be read
  std::vector<MeshCheck> meshes = {};     // of an asset
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

}  // namespace vcd::verify
