// Everything that a run has measured so far: one JSON file that is replaced whole after each measurement, so that a run
// can be stopped at any moment and go on later.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "common/describe.h"

namespace vcd::bench {

class Results {
 public:
  // Opens folder/results.json, or begins it. head: tool, settings and machine. Errors: io (the folder cannot be made or
  // read); invalid_file (not such a file); difference (it was measured with other settings or on another machine, and
  // figures of both would stand side by side).
  static Result<Results> open(const std::filesystem::path& folder, const tools::Json& head);

  // The scene's entry, made if there is none. Changes reach the disk with save().
  tools::Json& scene(const std::string& name);
  static tools::Json& variant(tools::Json& scene, const std::string& id);

  std::optional<Error> save() const;
  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
  tools::Json json_;
};

}  // namespace vcd::bench
