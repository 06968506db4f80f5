#include "program.h"
#include "paths.h"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <exception>
#include <fstream>
#include <map>
#include <new>

#include <fcntl.h>
#include <unistd.h>

namespace vcd::tools {
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

// CLI11 takes the brackets off a name like [x], and parts it at commas.
std::string with_brackets(const std::string& name) {
  return name.starts_with('[') && name.ends_with(']') ? "./" + name : name;
}

// Replaces each @FILE by the lines of FILE that are not empty.
std::vector<std::string> expand_lists(int argc, char** argv) {
  std::vector<std::string> arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.size() < 2 || argument[0] != '@') {
      arguments.push_back(with_brackets(argument));
      continue;
    }
    std::ifstream list(argument.substr(1));
    if (!list) throw CLI::ValidationError(argument, "cannot read this list of files");
    bool first = true;
    for (std::string line; std::getline(list, line); first = false) {
      if (first && (line.starts_with("\xFF\xFE") || line.starts_with("\xFE\xFF")))
        throw CLI::ValidationError(argument, "is UTF-16 text; a list of files is UTF-8");
      if (first && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
      if (!line.empty() && line.back() == '\r') line.pop_back();
      if (!line.empty()) arguments.push_back(with_brackets(line));
    }
  }
  return arguments;
}

// Standard output may have been full, or closed.
int flushed(int code) {
  if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return code;
  print_error("cannot write to standard output");
  return exit_code(ErrorCode::io);
}

}  // namespace

void add_common_options(CLI::App& app, CommonOptions& options) {
  static const std::map<std::string, OutputFormat> kFormats = {{"text", OutputFormat::text},
                                                               {"json", OutputFormat::json}};
  app.add_flag("-q,--quiet", options.quiet, "No notes, no progress, no summary; errors only");
  app.add_option("--format", options.format, "What to print on standard output (default: text)")
      ->transform(CLI::CheckedTransformer(kFormats, CLI::ignore_case).description(""))
      ->type_name("text|json");
  app.set_version_flag("--version", "vcd " VCD_VERSION);
  app.footer(kExitCodes);
}

int run_program(CLI::App& app, int argc, char** argv, const std::function<int()>& body) {
  // Were one of the standard streams closed, the next file or pipe would be taken for it.
  int stream = 0;
  do stream = open("/dev/null", O_RDWR);
  while (stream >= 0 && stream <= STDERR_FILENO);
  close(stream);
  try {
    std::vector<std::string> arguments = expand_lists(argc, argv);
    app.name(std::string(argv[0]).substr(std::string(argv[0]).find_last_of('/') + 1));
    if (!app.get_subcommands({}).empty()) app.set_help_all_flag("--help-all", "Print the help of all commands");
    std::reverse(arguments.begin(), arguments.end());  // as CLI11 wants them
    app.parse(std::move(arguments));
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kExitOk : exit_code(ErrorCode::usage);
  }
  try {
    return flushed(body());
  } catch (const std::bad_alloc&) {
    print_error("out of memory");
  } catch (const std::exception& e) {
    print_error(e.what());
  }
  return exit_code(ErrorCode::runtime);
}

void catch_interruptions() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP})
    if (std::signal(signal, on_signal) == SIG_IGN) std::signal(signal, SIG_IGN);  // as nohup wants it
}
bool interrupted() { return g_interrupted; }

void print_error(const std::string& message) { std::fprintf(stderr, "error: %s\n", shown(message).c_str()); }
void print_note(const std::string& message) { std::fprintf(stderr, "note: %s\n", shown(message).c_str()); }

}  // namespace vcd::tools
