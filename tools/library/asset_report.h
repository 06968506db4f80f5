// What came of one asset, as JSON and for people.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <vcd/library/assets.h>
#include <vcd/library/object_cache.h>

namespace vcd::library {

// One object of an asset: baked now, or known before.
struct FinishedObject {
  uint64_t duplicate_triangles = 0, zero_area_triangles = 0;  // dropped while welding
  std::optional<CachedObject> known = {};
  baker::BakedObject baked = {};                   // where it was not known
  std::optional<baker::DemandReport> demand = {};  // where it was baked for one

  ObjectToWrite to_write() const { return known ? known->to_write() : baked.to_write(); }
};

// A JSON object: input, output, bytes, notes, objects.
std::string asset_report(const Asset& asset, uint64_t bytes, const std::vector<std::string>& notes,
                         const std::vector<FinishedObject>& objects);
std::string asset_summary(const Asset& asset, uint64_t bytes, const std::vector<FinishedObject>& objects);

}  // namespace vcd::library
