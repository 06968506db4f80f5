// One asset, from mesh file to sidecar: what a child process of a run does.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "assets.h"

namespace vcd {

struct BakeContext {
  unsigned threads = 0;         // 0: all
  std::filesystem::path cache;  // folder of baked objects; empty: none
  bool reuse = false;           // take objects that did not change from the sidecar in place
  IngestLimits ingest;          // of the parser's own child process
  std::function<void(const std::string&)> on_stage = [](const std::string&) {};  // "reading", "baking", …
  std::function<void(const BakeProgress&)> on_progress = [](const BakeProgress&) {};
};

struct BakedAsset {
  Json report;          // input, output, bytes, notes, objects with their figures
  std::string summary;  // the same for people, several lines
  std::vector<SourceFile> sources;
};

// Errors name the input: those of ingest_isolated, prepare, bake and write_sidecar; io (a source file changed
// meanwhile). Then nothing is written.
Result<BakedAsset> bake_asset(const Asset& asset, const BakeContext& context);

}  // namespace vcd
