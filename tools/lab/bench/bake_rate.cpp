#include "bake_rate.h"

#include <algorithm>
#include <cstdio>
#include <random>
#include <utility>
#include <vector>

#include <vcd/baker/sampled.h>
#include <vcd/baker/tracer.h>
#include <vcd/format/line_cell.h>

#include "common/describe.h"
#include "machine.h"
#include "timing.h"
#include "traced_mesh.h"

namespace vcd::bench {

using namespace baker;
using namespace tools;
namespace {

// The baker's recursion below one cell; visit(cell, rays) sees every cell and how many rays it took.
template <class Visit>
void classify_below(const SampledClassifier& classifier, const Cell& cell, uint32_t depth, const Visit& visit) {
  uint64_t rays = 0;
  const CellVerdict verdict = classifier.classify(cell, rays);
  visit(cell, static_cast<uint32_t>(rays));
  if (verdict != CellVerdict::mixed || cell.level == depth) return;
  for (uint32_t i = 0; i < 16; ++i) classify_below(classifier, cell.child(i), depth, visit);
}

// The sample lines of all cells, packed sixteen to a packet in the order in which the bake traces them.
std::vector<RTCRay16> record(const SampledClassifier& classifier, const std::vector<Cell>& cells, uint32_t depth) {
  std::vector<RTCRay16> packets;
  uint32_t used = 16;
  const auto append = [&](const RTCRay16& from, uint32_t k) {
    if (used == 16) packets.push_back(from), used = 0;
    RTCRay16& to = packets.back();
    to.org_x[used] = from.org_x[k], to.org_y[used] = from.org_y[k], to.org_z[used] = from.org_z[k];
    to.dir_x[used] = from.dir_x[k], to.dir_y[used] = from.dir_y[k], to.dir_z[used] = from.dir_z[k];
    ++used;
  };
  for (const Cell& cell : cells)
    classify_below(classifier, cell, depth, [&](const Cell& visited, uint32_t rays) {
      for (uint32_t first = 0; first < rays; first += 16) {
        RTCRay16 packet;
        const uint32_t count = std::min(rays - first, 16u);
        classifier.fill(visited, first, count, 16, packet);
        for (uint32_t k = 0; k < count; ++k) append(packet, k);
      }
    });
  if (!packets.empty()) packets.pop_back();  // perhaps not full
  return packets;
}

void trace_bare(RTCScene scene, const std::vector<RTCRay16>& packets) {
  alignas(64) int32_t lanes[16];
  std::fill_n(lanes, 16, -1);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  for (const RTCRay16& packet : packets) {
    RTCRay16 copy = packet;
    rtcOccluded16(lanes, scene, &context, &copy);
  }
}

struct BakeRate {
  uint64_t rays = 0;      // that the classification traced
  Timing classification;  // the baker's own recursion, one thread
  Timing bare16;          // rtcOccluded16 on the very same rays, sixteen at a time, in the same order
};

Result<BakeRate> measure_bake_rate(const PreparedMesh& mesh, const BakeRateOptions& options, int repetitions) {
  const auto tracer = Tracer::build(positions_in_grid(mesh), mesh.triangles);
  if (!tracer) return tracer.error();
  const SampledClassifier classifier(*tracer, options.samples, 0);

  std::mt19937 random(1);
  std::vector<Cell> cells(options.top_cells);
  const auto below = [&](uint32_t n) { return static_cast<uint32_t>(random() % n); };
  for (Cell& cell : cells) cell = {below(kFacePairs), 3, below(8), below(8), below(8), below(8)};

  const std::vector<RTCRay16> packets = record(classifier, cells, options.depth);
  const std::vector<Variant> variants = {
      {"the bake's recursion",
       [&] {
         for (const Cell& cell : cells) classify_below(classifier, cell, options.depth, [](const Cell&, uint32_t) {});
       }},
      {"bare rtcOccluded16, coherent", [&] { trace_bare(tracer->scene(), packets); }}};
  const std::vector<Timing> timings = time_interleaved(variants, repetitions);
  return BakeRate{packets.size() * 16, timings[0], timings[1]};
}

}  // namespace

int run_bake_rate(const MeshToRead& mesh, const BakeRateOptions& options, int repetitions, OutputFormat format) {
  const auto loaded = TracedMesh::load(mesh);
  if (!loaded) return print_error(loaded.error().message), exit_code(loaded.error().code);
  const auto rate = measure_bake_rate(loaded->mesh, options, repetitions);
  if (!rate) return print_error(rate.error().message), exit_code(rate.error().code);
  const double rays = static_cast<double>(rate->rays);
  if (format == OutputFormat::json) {
    print_json({{"tool", "vc-bench"},
                {"version", VCD_VERSION},
                {"machine", machine_description()},
                {"rays", rate->rays},
                {"classification_ns", 1e9 * rate->classification.median / rays},
                {"rtcOccluded16_ns", 1e9 * rate->bare16.median / rays},
                {"ratio", rate->bare16.median / rate->classification.median}});
    return kExitOk;
  }
  std::printf("%s, one thread, %d interleaved repetitions: medians (minimum to maximum)\n%llu rays of a bake\n",
              machine_description().c_str(), repetitions, static_cast<unsigned long long>(rate->rays));
  print_timing(rate->classification, rate->rays);
  print_timing(rate->bare16, rate->rays);
  std::printf("  the bake traces at %.2f times the rate of bare rtcOccluded16 on the same rays\n",
              rate->bare16.median / rate->classification.median);
  return kExitOk;
}

}  // namespace vcd::bench
