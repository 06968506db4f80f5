#include "plan_report.h"

#include <cstdio>

#include "readable.h"

namespace vcd::tools {

using namespace baker;

Json describe_plan(const Plan& plan) {
  Json json{
      {"depth", plan.depth}, {"worth_it", plan.depth > 0}, {"reason", plan.reason}, {"probe_seconds", plan.seconds}};
  json["forecasts"] = Json::array();
  for (const DepthForecast& f : plan.forecasts)
    json["forecasts"].push_back({{"depth", f.depth},
                                 {"bytes", f.bytes},
                                 {"seconds", f.seconds},
                                 {"resolved", f.resolved},
                                 {"resolved_shadow", f.resolved_shadow},
                                 {"gain", f.gain}});
  return json;
}

void print_plan(const Plan& plan) {
  std::printf("  %-6s %12s %12s %10s %16s %6s\n", "depth", "tree", "bake", "resolved", "of shadow rays", "gain");
  for (const DepthForecast& f : plan.forecasts)
    std::printf("%c %-6u %12s %12s %8.1f %% %14.1f %% %6.2f\n", f.depth == plan.depth ? '*' : ' ', f.depth,
                readable_bytes(f.bytes).c_str(), readable_seconds(f.seconds).c_str(), 100 * f.resolved,
                100 * f.resolved_shadow, f.gain);
  std::printf("  %s: %s (probed in %s)\n",
              plan.depth ? ("depth " + std::to_string(plan.depth)).c_str() : "not worth it", plan.reason.c_str(),
              readable_seconds(plan.seconds).c_str());
}

}  // namespace vcd::tools
