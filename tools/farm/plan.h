// A library cut into shards, and what became of them: a folder that every machine of a farm can reach.
//
//   PLAN/plan.json          which shards there are
//   PLAN/shard-0001.json    one shard: a manifest for vc-bake, every asset by its absolute path
//   PLAN/shard-0001.events.jsonl   what happens in it, as it happens
//   PLAN/shard-0001.report.json    what came of it; there once the shard is done
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <vcd/library/assets.h>

#include "common/describe.h"

namespace vcd::farm {

struct Shard {
  unsigned number;  // from 1
  size_t assets;
  double seconds;  // guessed, on one thread
};

struct FarmPlan {
  std::filesystem::path folder;
  std::vector<Shard> shards;

  std::filesystem::path file(unsigned shard, const std::string& extension) const;  // PLAN/shard-0001EXTENSION
};

// Cuts the assets into at most so many shards whose guessed costs are as equal as the longest first rule makes them,
// and writes them. Errors: usage (no asset, or the folder holds a plan already), io.
Result<FarmPlan> make_plan(const std::filesystem::path& folder, const std::vector<library::Asset>& assets,
                           unsigned shards);
Result<FarmPlan> open_plan(const std::filesystem::path& folder);  // Errors: io, invalid_file

// How far a shard is, as its files tell.
struct ShardState {
  bool done = false;  // its report is there, and says of each asset, and of no other, what became of it
  bool started = false;
  size_t ended = 0;  // assets
  size_t failed = 0;
};
ShardState state_of(const FarmPlan& plan, const Shard& shard);

// Makes what a run of the shard wrote to `name`.json and .html the shard's report, unless that run was broken off and
// there is a whole one. Whether it is whole.
bool take_report(const FarmPlan& plan, const Shard& shard, const std::string& name);

// One report of all shards; assets of shards that are not done count as not run.
tools::Json merged_report(const FarmPlan& plan);

}  // namespace vcd::farm
