#include "command.h"

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <utility>

#include <spawn.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <vcd/baker/child_process.h>

#include "common/program.h"

extern char** environ;

namespace vcd::farm {

using namespace baker;
using namespace tools;
namespace {

std::vector<char*> arguments_of(const std::vector<std::string>& command) {
  std::vector<char*> arguments;
  for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  return arguments;
}

Result<pid_t> spawn(const std::vector<std::string>& command, const posix_spawn_file_actions_t* actions) {
  pid_t pid = 0;
  const int fault = posix_spawnp(&pid, command[0].c_str(), actions, nullptr, arguments_of(command).data(), environ);
  if (fault != 0) return Error{ErrorCode::runtime, command[0] + ": cannot be run: " + std::strerror(fault)};
  return pid;
}

int wait_for(pid_t pid) {
  int status = 0;
  bool told = false;
  while (waitpid(pid, &status, WNOHANG) == 0) {
    if (interrupted() && !std::exchange(told, true)) kill(pid, SIGTERM);
    usleep(20000);
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

std::string content_of(int file) {
  struct stat status {};
  fstat(file, &status);
  std::string text(static_cast<size_t>(status.st_size), '\0');
  const ssize_t got = pread(file, text.data(), text.size(), 0);
  text.resize(got < 0 ? 0 : static_cast<size_t>(got));
  return text;
}

}  // namespace

Result<std::string> output_of(const std::vector<std::string>& command) {
  const Descriptor out(memfd_create("out", MFD_CLOEXEC)), words(memfd_create("words", MFD_CLOEXEC));
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, out.get(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, words.get(), STDERR_FILENO);
  const auto pid = spawn(command, &actions);
  posix_spawn_file_actions_destroy(&actions);
  if (!pid) return pid.error();
  if (const int code = wait_for(*pid); code != 0)
    return Error{ErrorCode::runtime,
                 command[0] + " ended with " + std::to_string(code) + ": " + content_of(words.get())};
  return content_of(out.get());
}

Result<int> run_command(const std::vector<std::string>& command) {
  const pid_t parent = getpid(), pid = fork();
  if (pid < 0) return Error{ErrorCode::runtime, command[0] + ": cannot be run: " + std::strerror(errno)};
  if (pid == 0) {
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() == parent) execvp(arguments_of(command)[0], arguments_of(command).data());
    std::fprintf(stderr, "error: %s: cannot be run: %s\n", command[0].c_str(), std::strerror(errno));
    _exit(exit_code(ErrorCode::runtime));
  }
  return wait_for(pid);
}

std::string shell_word(const std::string& text) {
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

}  // namespace vcd::farm
