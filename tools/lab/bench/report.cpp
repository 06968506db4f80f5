#include "report.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>

#include <spawn.h>
#include <sys/wait.h>

#include "common/program.h"

extern char** environ;

namespace vcd::bench {

using namespace tools;
namespace {

std::string python() {
  if (const char* chosen = std::getenv("VCD_PYTHON")) return chosen;
  return std::filesystem::exists("/usr/bin/python3") ? "/usr/bin/python3" : "python3";
}

}  // namespace

int write_report(const std::filesystem::path& folder) {
  std::error_code failed;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", failed);
  std::string interpreter = python(), target = folder.string();
  std::string script = (program.parent_path().parent_path() / "share/vcd/report/vcd_report.py").string();
  char* arguments[] = {interpreter.data(), script.data(), target.data(), nullptr};
  pid_t child = 0;
  if (const int code = posix_spawnp(&child, interpreter.c_str(), nullptr, nullptr, arguments, environ); code != 0) {
    print_error(interpreter + ": cannot be started: " + std::strerror(code));
    return exit_code(ErrorCode::runtime);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return exit_code(ErrorCode::runtime);
  return WIFEXITED(status) ? WEXITSTATUS(status) : exit_code(ErrorCode::runtime);
}

}  // namespace vcd::bench
