// A piece of work that makes meshes, done in a child process with limits. ingest_isolated is this around
// ingest().
#pragma once

#include <vcd/baker/ingest.h>

#include <filesystem>
#include <functional>

namespace vcd::baker {

// Runs `work` in a forked child and brings its result back.
//
// Returns what `work` returns, value or Error. Errors of its own, all of code runtime, begin with the name of
// `path` (which is only named, never opened) and end with the last words that the child wrote to stdout or
// stderr: it crashed, ran out of time or memory, or ended without a result. Nothing that the child prints
// reaches the caller's stdout or stderr.
//
// What the child sends back is checked like a file from a stranger. The child is reaped before the call returns, which
// leaves no file descriptor open. Safe from any thread, also while others run; `work` must not need the other threads
// or locks that they may hold (malloc and stdio are fine: glibc sees to them at fork). No exception leaves.
Result<Ingested> run_isolated(const std::filesystem::path& path, const IngestLimits& limits,
                              const std::function<Result<Ingested>()>& work);

}  // namespace vcd::baker
