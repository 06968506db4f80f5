#include "variant_json.h"

#include <algorithm>

#include <vcd/baker/audit.h>

#include "kinds.h"

namespace vcd::bench {

using namespace baker;
using namespace tools;
using namespace render;

void describe_trees(const std::vector<Object>& objects, Json& v) {
  uint64_t bytes = 0, unfolded = 0, folded = 0, shared = 0;
  for (const Object& object : objects) {
    const ObjectRecord& r = object.record();
    bytes += tree_shape(r.depth).bytes(r.block_counts, r.brick_count);
    unfolded += 4 * r.nodes_unfolded, folded += 4 * r.nodes_folded, shared += 4 * r.nodes_shared;
  }
  v["memory_bytes"] = bytes;
  v["nodes"] = {{"unfolded_bytes", unfolded}, {"folded_bytes", folded}, {"shared_bytes", shared}};
}

Json describe_ways(const ShadowWays& ways) {
  Json json = Json::array();
  for (size_t kind = 0; kind < ways.traced.size(); ++kind)
    json.push_back({{"traced", name_of(ways.traced[kind])},
                    {"left", name_of(ways.left[kind])},
                    {"look_up", ways.policy.look_up(static_cast<From>(kind))}});
  return json;
}

ShadowWays ways_of(const Json& json) {
  const auto named = [](const Json& name) {
    for (const EmbreeQuery& query : all_packets(false))
      if (name_of(query) == name) return query;
    return EmbreeQuery{1};
  };
  ShadowWays ways;
  for (size_t kind = 0; kind < ways.traced.size(); ++kind) {
    ways.traced[kind] = named(json[kind]["traced"]), ways.left[kind] = named(json[kind]["left"]);
    ways.policy.fix(static_cast<From>(kind),
                    json[kind]["look_up"] ? LookUpPolicy::Use::always : LookUpPolicy::Use::never);
  }
  return ways;
}

void describe_wrong(Json& v, const KindCounts& total) {
  v["wrong"] = total.wrong;
  v["wrong_rate"] = static_cast<double>(total.wrong) / static_cast<double>(std::max<uint64_t>(total.segments, 1));
  v["wrong_bound_95"] = upper_bound_95(total.wrong, total.segments);
}

void describe_kinds(Json& v, const CensusPass& pass) {
  v["kinds"] = Json::array();
  for (size_t k = 0; k < kSegmentKinds; ++k) {
    if (pass.kinds[k].segments == 0) continue;
    Json kind{{"kind", segment_kind_name(static_cast<SegmentKind>(k))}};
    kind.update(describe_counts(pass.kinds[k]));
    v["kinds"].push_back(kind);
  }
}

}  // namespace vcd::bench
