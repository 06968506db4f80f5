#include "program.h"
#include "paths.h"

#include <atomic>
#include <csignal>
#include <cstdio>
#include <exception>
#include <fstream>
#include <map>
#include <new>

namespace vcd {
namespace {

std::atomic<bool> g_interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void on_signal(int signal) {
  g_interrupted = true;
  std::signal(signal, SIG_DFL);
}

constexpr const char* kExitCodes = R"(Exit codes:
  0  ok                     5  unsupported
  1  wrong usage            7  difference found
  2  input or output        8  stale sidecar
  3  invalid file           9  part of a batch failed
  4  failure while running)";

// Replaces each @FILE by the lines of FILE that are not empty.
std::vector<std::string> expand_lists(int argc, char** argv) {
  std::vector<std::string> arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.size() < 2 || argument[0] != '@') {
      arguments.push_back(argument);
      continue;
    }
    std::ifstream list(argument.substr(1));
    if (!list) throw CLI::ValidationError(argument, "cannot read this list of files");
    for (std::string line; std::getline(list, line);) {
      if (!line.empty() && line.back() == '\r') line.pop_back();
      if (!line.empty()) arguments.push_back(line);
    }
  }
  return arguments;
}

}  // namespace

void add_common_options(CLI::App& app, CommonOptions& options) {
  static const std::map<std::string, OutputFormat> kFormats = {{"text", OutputFormat::text},
                                                               {"json", OutputFormat::json}};
  app.add_flag("-q,--quiet", options.quiet, "No notes, no progress, no summary; errors only");
  app.add_flag("-v,--verbose", options.verbose, "Say more");
  app.add_option("--format", options.format, "What to print on standard output: text or json (default: text)")
      ->transform(CLI::CheckedTransformer(kFormats, CLI::ignore_case).description(""))
      ->type_name("FORMAT");
  app.set_version_flag("--version", "vcd " VCD_VERSION);
  app.footer(kExitCodes);
}

int run_program(CLI::App& app, int argc, char** argv, const std::function<int()>& body) {
  try {
    std::vector<std::string> arguments = expand_lists(argc, argv);
    app.name(std::string(argv[0]).substr(std::string(argv[0]).find_last_of('/') + 1));
    std::reverse(arguments.begin(), arguments.end());  // as CLI11 wants them
    app.parse(std::move(arguments));
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kExitOk : exit_code(ErrorCode::usage);
  }
  try {
    const int code = body();
    if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return code;
    print_error("cannot write to standard output");
    return exit_code(ErrorCode::io);
  } catch (const std::bad_alloc&) {
    print_error("out of memory");
  } catch (const std::exception& e) {
    print_error(e.what());
  }
  return exit_code(ErrorCode::runtime);
}

int batch_exit_code(const std::vector<int>& codes) {
  if (codes.size() == 1) return codes[0];
  for (int code : codes)
    if (code != kExitOk) return kExitBatch;
  return kExitOk;
}

void catch_interruptions() {
  for (int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, on_signal);
}
bool interrupted() { return g_interrupted; }

void print_error(const std::string& message) { std::fprintf(stderr, "error: %s\n", shown(message).c_str()); }
void print_note(const std::string& message) { std::fprintf(stderr, "note: %s\n", shown(message).c_str()); }

}  // namespace vcd
