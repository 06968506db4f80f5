#include "demand/divide_for.h"

#include <algorithm>
#include <string>

#include <vcd/baker/demand.h>
#include <vcd/baker/threads.h>

#include "demand/asked_lines.h"
#include "demand/kept_out.h"
#include "prepare/place.h"
#include "seconds_since.h"

namespace vcd::baker {

Result<std::span<const AskedSegment>> asked_of(const PreparedMesh& mesh, const Demand& demand) {
  const auto usage = [&](const std::string& reason) { return Error{ErrorCode::usage, place_of(mesh) + ": " + reason}; };
  const auto found = demand.find(mesh.geometry_hash);
  if (found == demand.end()) return usage("the demand asks nothing of it; it was made for another mesh, or version");
  const std::span<const AskedSegment> asked = found->second;
  const GridFrame frame = make_grid_frame(mesh.box_min.data(), mesh.box_max.data());
  if (std::ranges::none_of(asked, [&](const AskedSegment& s) { return enters_box(frame, s.segment); }))
    return usage("none of the demand's " + std::to_string(asked.size()) + " segments enters its box");
  return asked;
}

Result<BestFirst> divide_for(std::span<const AskedSegment> asked, const GridMesh& grid, const Tracer& tracer,
                             const KnownCells& classifier, const uint8_t* clearances, uint32_t depth,
                             uint64_t budget_bytes, std::chrono::steady_clock::time_point deadline,
                             const BakeOptions& options) {
  std::vector<AskedSegment> looked_at;
  std::ranges::copy_if(asked, std::back_inserter(looked_at),
                       [](const AskedSegment& s) { return !is_kept_out(s.segment); });
  auto divided = with_threads(options.threads, [&] {
    const auto start = std::chrono::steady_clock::now();
    const std::vector<AskedLine> lines = asked_lines(grid, tracer, clearances, looked_at);
    BestFirstOptions how{depth, budget_bytes, options.depth_elsewhere, deadline, options.stop};
    if (options.progress)
      how.progress = [&](double fraction, uint64_t rays) { options.progress({fraction, rays, seconds_since(start)}); };
    return divide_best_first(classifier, lines, how);
  });
  if (!divided) return Error{ErrorCode::runtime, place_of(grid.source) + ": stopped"};
  if (divided->too_deep_elsewhere)
    return Error{ErrorCode::usage, place_of(grid.source) + ": depth " + std::to_string(options.depth_elsewhere) +
                                       " everywhere takes more than the budget of bytes"};
  return std::move(*divided);
}

}  // namespace vcd::baker
