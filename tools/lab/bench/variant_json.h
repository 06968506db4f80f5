// What the results say of one variant of a scene.
#pragma once

#include <vector>

#include "common/describe.h"
#include "render/census.h"
#include "render/shadows.h"

namespace vcd::bench {

// Bytes of the trees: in memory, and as nodes in the paper's units.
void describe_trees(const std::vector<Object>& objects, tools::Json& variant);

// How rays are asked, by where they begin; and back.
tools::Json describe_ways(const render::ShadowWays& ways);
render::ShadowWays ways_of(const tools::Json& json);

// Wrong answers with their rate and its 95 % bound; and the counts of each kind of segment.
void describe_wrong(tools::Json& variant, const render::KindCounts& total);
void describe_kinds(tools::Json& variant, const render::CensusPass& pass);

}  // namespace vcd::bench
