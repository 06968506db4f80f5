// One asset, from mesh file to sidecar: what a child process of a run does.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <vcd/library/assets.h>

namespace vcd::library {

struct BakeContext {
  unsigned threads = 0;         // 0: all
  std::filesystem::path cache;  // folder of baked objects; empty: none
  bool reuse = false;           // take objects that did not change from the sidecar in place
  bool measure = false;         // of settings.total_mb, find out what the objects would do with it; write nothing
  baker::IngestLimits ingest;   // of the parser's own child process
  std::function<void(const std::string&)> on_stage = [](const std::string&) {};  // "reading", "baking", …
  std::function<void(const baker::BakeProgress&)> on_progress = [](const baker::BakeProgress&) {};
};

struct BakedAsset {
  uint64_t bytes = 0;               // of the sidecar
  size_t objects_reused = 0;        // of its objects, those that were not baked anew
  std::vector<std::string> notes;   // what was left out, a sentence each
  std::vector<WantedBytes> wanted;  // of its objects, where that was measured
  std::string summary;              // for people, several lines
  std::string report;               // JSON: input, output, bytes, notes, objects with their figures
  // Files that the mesh file names and that were read, relative to its folder.
  std::vector<std::filesystem::path> sources;
};

// Errors name the input: those of ingest_isolated, prepare, bake and write_sidecar; io (a source file changed
// meanwhile). Then nothing is written.
Result<BakedAsset> bake_asset(const Asset& asset, const BakeContext& context);

}  // namespace vcd::library
