// How the assets of a run share settings.total_mb.
#pragma once

#include <span>
#include <vector>

#include <vcd/library/batch.h>

namespace vcd::library {

// After look_at() and before run_batch(): assets with the same total_mb share it, where they are several. If one of
// them waits, all do. Each is baked as if all bytes were its own, and nothing is written; then assets[i].shares says
// what each object gets. So a sidecar depends on all that share with it, and on nothing that was there before.
//
// An asset that fails so has its record, of which the listeners hear, and the others share without it; with fail_fast
// or stop, none is left waiting. Where all fail to fit together, all fail. Threads and processes: as run_batch().
void share_totals(std::vector<Asset>& assets, std::vector<Record>& records, const BatchOptions& options,
                  std::span<BatchListener* const> listeners);

}  // namespace vcd::library
