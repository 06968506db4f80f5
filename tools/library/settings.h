// What one asset is baked with: the options that decide about the bytes of its sidecar.
#pragma once

#include <string>

#include <vcd/baker/bake.h>
#include <vcd/baker/ingest.h>

#include "common/describe.h"

namespace CLI {
class App;
}

namespace vcd {

struct BakeSettings {
  std::string depth = "auto";  // or "1" … "8"
  double budget_mb = 0;        // MiB; 0: none
  bool method_named = false;   // by --method: then --samples does not mean sampled
  BakeOptions bake;            // method, samples, seed, budget_seconds, embed_geometry; the rest is not a setting
  IngestOptions ingest;
  uint64_t audit_lines = 1000000;
  Storage storage = Storage::raw;

  BakeOptions bake_options() const;  // depth, budget and audit filled in

  // All of them, as changed() takes them. Two settings with the same members make the same sidecar of the same mesh.
  Json members() const;
};

// Adds the options. `settings` is filled when the app parses and outlives it.
void add_settings(CLI::App& app, BakeSettings& settings);

// `base` with the members of a JSON object in place: their names are the options' long names, values numbers, texts or,
// for flags, true or false. Error (usage) for what the command line would not take either.
Result<BakeSettings> changed(const BakeSettings& base, const Json& members);

}  // namespace vcd
