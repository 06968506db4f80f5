// What every vcd program does alike: options, help, exit codes, lists of files, interruption.
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <vcd/format/error.h>

namespace vcd {

inline constexpr int kExitOk = 0;
inline constexpr int kExitBatch = 9;  // some of several inputs failed
inline int exit_code(ErrorCode code) { return static_cast<int>(code); }

enum class OutputFormat { text, json };

// Of numbers from `least` to `most`. CLI::Range alone takes NaN, which is neither less nor more.
class NumberRange : public CLI::Range {
 public:
  NumberRange(double least, double most) : CLI::Range(least, most) {
    func_ = [in_range = func_](std::string& text) {
      double number = 0;
      return CLI::detail::lexical_cast(text, number) && std::isnan(number) ? text + " is not a number" : in_range(text);
    };
  }
};

struct CommonOptions {
  bool quiet = false;
  OutputFormat format = OutputFormat::text;
};

// -q, --format text|json, --version, -h, and the table of exit codes at the end of the help.
void add_common_options(CLI::App& app, CommonOptions& options);

// Parses the arguments (each @FILE stands for the lines of FILE) and runs the body, which returns the exit code.
// Wrong arguments end in exit code 1. No exception leaves.
int run_program(CLI::App& app, int argc, char** argv, const std::function<int()>& body);

// The exit code for a batch: that of the only input, 0 if all are well, else 9.
int batch_exit_code(const std::vector<int>& codes);

// From now on SIGINT, SIGTERM and SIGHUP only set a flag, so that work in progress can stop and clean up. A second
// signal ends the program at once.
void catch_interruptions();
bool interrupted();

// "error: …" and "note: …", each on a line of stderr: line ends in names of files are escaped.
void print_error(const std::string& message);
void print_note(const std::string& message);

}  // namespace vcd
