// A whole run: every sidecar, side by side within one budget of threads; then what the library lacks.
#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include <vcd/verify/check.h>
#include <vcd/verify/inputs.h>
#include <vcd/verify/totals.h>

namespace vcd::verify {

struct RunOptions {
  std::vector<std::string> inputs;             // as find_inputs takes them
  std::vector<std::string> against_libraries;  // likewise
  CheckOptions check;                          // its library is set by run()
  std::set<std::string> allowed;               // ids of findings that are warnings then
  unsigned threads = 0;                        // files at a time, and threads in all; 0: one a processor
};

struct Run {
  // Of the inputs in their order, then of the libraries' inputs that failed, then of all assets.
  std::vector<Outcome> outcomes;
  Totals totals;

  // The exit code of the only sidecar or input, or 9 if anything failed. An asset counts where it failed.
  int exit_code() const;
};

// `tell` gets each outcome once it and those before it are there, one at a time, from any thread; it may take out of it
// what it has shown. Apart from errors for want of memory all results are the same whatever the threads.
Run run(const RunOptions& options, const std::function<void(Outcome&)>& tell);

}  // namespace vcd::verify
