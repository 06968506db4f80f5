#include "plan_report.h"

#include <cstdio>

#include "readable.h"

namespace vcd::tools {

using namespace baker;

Json describe_plan(const Plan& plan) {
  Json json{
      {"depth", plan.depth}, {"worth_it", plan.depth > 0}, {"reason", plan.reason}, {"probe_seconds", plan.seconds}};
  json["horizons"] = nullptr;
  if (plan.horizons)
    json["horizons"] = {{"bytes", plan.horizons->bytes},
                        {"seconds", plan.horizons->seconds},
                        {"uniform", plan.horizons->share.uniform},
                        {"cosine", plan.horizons->share.cosine}};
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
  if (!plan.horizons) return;
  const HorizonForecast& h = *plan.horizons;
  std::printf("  horizons: %s, baked in %s, answer %.0f %% of the rays that start on it, %.0f %% by their cosine%s\n",
              readable_bytes(h.bytes).c_str(), readable_seconds(h.seconds).c_str(), 100 * h.share.uniform,
              100 * h.share.cosine, h.bytes ? "" : ": not worth it");
}

}  // namespace vcd::tools
