#include "ingest/isolate.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>
#include <string_view>

#include "ingest/check.h"
#include "ingest/wire.h"

namespace vcd {
namespace {

using Clock = std::chrono::steady_clock;

// The sanitizers map terabytes of shadow memory.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kLimitMemory = false;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
constexpr bool kLimitMemory = false;
#else
constexpr bool kLimitMemory = true;
#endif
#else
constexpr bool kLimitMemory = true;
#endif

// What the child exits with when it could not send its result; any number that is rare elsewhere.
constexpr int kCannotSend = 113;

class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { close(); }

  int get() const { return number_; }
  void reset(int number) {
    close();
    number_ = number;
  }
  void close() {
    if (number_ >= 0) ::close(number_);
    number_ = -1;
  }

 private:
  int number_ = -1;
};

// Blocks every signal for the calling thread, so that no handler of the caller runs in the child between fork
// and reset_signals(): it might remove the caller's temporary files.
class BlockedSignals {
 public:
  BlockedSignals() {
    sigset_t all;
    sigfillset(&all);
    ::pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;
  ~BlockedSignals() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

 private:
  sigset_t before_;
};

void reset_signals() {
  for (int number = 1; number < NSIG; ++number) ::signal(number, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  ::pthread_sigmask(SIG_SETMASK, &none, nullptr);
}

// The bytes of address space that the process has mapped; 0 if the system does not say.
uint64_t mapped_bytes() {
  const Descriptor file(::open("/proc/self/statm", O_RDONLY | O_CLOEXEC));
  char text[64] = {};
  if (file.get() < 0 || ::read(file.get(), text, sizeof(text) - 1) <= 0) return 0;
  return std::strtoull(text, nullptr, 10) * static_cast<uint64_t>(::sysconf(_SC_PAGESIZE));
}

void lower_limit(__rlimit_resource resource, uint64_t value) {
  rlimit limit;
  if (::getrlimit(resource, &limit) != 0) return;
  limit.rlim_cur = std::min<rlim_t>(value, limit.rlim_max);
  ::setrlimit(resource, &limit);
}

// The child's whole life. `path` is for messages.
[[noreturn]] void live_as_child(const std::filesystem::path& path, const IngestLimits& limits,
                                const std::function<Result<Ingested>()>& work, pid_t parent, int result_file,
                                int words_pipe) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(kCannotSend);  // it died before it could be bound to this process
  reset_signals();
  ::dup2(words_pipe, STDOUT_FILENO);
  ::dup2(words_pipe, STDERR_FILENO);
  lower_limit(RLIMIT_CORE, 0);
  const uint64_t mapped = mapped_bytes();
  if (kLimitMemory && limits.memory_bytes < UINT64_MAX - mapped)
    lower_limit(RLIMIT_AS, mapped + limits.memory_bytes);
  bool sent = false;
  try {
    sent = write_result(result_file, work());
  } catch (const std::bad_alloc&) {
    sent = write_result(result_file, file_error(path, ErrorCode::runtime, "out of memory while reading"));
  } catch (const std::exception& error) {
    sent = write_result(
        result_file, file_error(path, ErrorCode::runtime, std::string("the parser failed: ") + error.what()));
  }
  ::_exit(
      sent ? 0
           : kCannotSend);  // neither the caller's destructors nor its stdio buffers are the child's business
}

// Keeps the end of what the child prints.
class LastWords {
 public:
  // Takes what the pipe holds now. Returns false once no one can write to it any more.
  bool drain(int pipe) {
    char chunk[4096];
    for (;;) {
      const ssize_t got = ::read(pipe, chunk, sizeof(chunk));
      if (got > 0) {
        kept_.append(chunk, static_cast<size_t>(got));
        if (kept_.size() > 2 * kMost) kept_.erase(0, kept_.size() - kMost);
        continue;
      }
      if (got < 0 && errno == EINTR) continue;
      return got < 0 && errno == EAGAIN;
    }
  }

  // The last two lines that say something, ready to end a message; empty if there are none.
  std::string text() const {
    std::string words;
    std::string_view rest = kept_;
    for (int lines = 0; lines < 2 && !rest.empty();) {
      const size_t start = rest.find_last_of('\n') + 1;  // 0 if there is no line end
      const std::string line = printable(rest.substr(start));
      rest = rest.substr(0, start == 0 ? 0 : start - 1);
      if (line.find_first_not_of(' ') == std::string::npos) continue;
      words = words.empty() ? line : line + "; " + words;
      ++lines;
    }
    return words.empty() ? "" : ": " + words;
  }

 private:
  static constexpr size_t kMost = 4096;

  static std::string printable(std::string_view line) {
    constexpr size_t kLongest = 200;
    std::string text;
    for (const char c : line.substr(0, kLongest)) text += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    return text;
  }

  std::string kept_;
};

// The child as its parent sees it: killed and reaped when this goes, if it has not ended by then.
class Child {
 public:
  explicit Child(pid_t pid) : pid_(pid) {}
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    if (!ended_) kill_and_reap();
  }

  // Waits for its end, listening to its words. Returns false if it had to be killed at the deadline.
  bool wait(Clock::time_point deadline, int words_pipe, LastWords& words) {
    bool open = true;
    while (!has_ended()) {
      const auto left =
          std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
      if (left <= 0) {
        kill_and_reap();
        words.drain(words_pipe);
        return false;
      }
      // The pipe closes when the child ends, unless another thread forked meanwhile and holds its other end
      // too: hence the short naps. Once it is closed there is nothing to poll.
      pollfd waiting = {open ? words_pipe : -1, POLLIN, 0};
      ::poll(&waiting, 1, static_cast<int>(std::min<int64_t>(left, open ? 20 : 1)));
      if (open) open = words.drain(words_pipe);
    }
    if (open) words.drain(words_pipe);
    return true;
  }

  // How it ended; empty if it ended well.
  std::string fault() const {
    if (WIFSIGNALED(status_)) {
      const int number = WTERMSIG(status_);
      const char* name = ::sigabbrev_np(number);
      const std::string signal =
          name == nullptr ? "signal " + std::to_string(number) : std::string("SIG") + name;
      // Nobody else kills with this one but the kernel, for want of memory, or an impatient user.
      if (number == SIGKILL) return "the parser was killed (SIGKILL), perhaps for want of memory";
      return "the parser crashed (" + signal + ")";
    }
    const int code = WEXITSTATUS(status_);
    if (code == kCannotSend) return "the parser's result could not be sent back, perhaps for want of memory";
    return code == 0 ? "" : "the parser ended before its time (exit status " + std::to_string(code) + ")";
  }

 private:
  bool has_ended() {
    const pid_t got = ::waitpid(pid_, &status_, WNOHANG);
    // ECHILD: the caller ignores SIGCHLD, so that the kernel reaps. Then only the result can tell how it
    // ended.
    ended_ = got == pid_ || (got < 0 && errno == ECHILD);
    return ended_;
  }

  void kill_and_reap() {
    ::kill(pid_, SIGKILL);
    while (::waitpid(pid_, &status_, 0) < 0 && errno == EINTR) {
    }
    ended_ = true;
  }

  pid_t pid_;
  int status_ = 0;
  bool ended_ = false;
};

Clock::time_point deadline_after(double seconds) {
  constexpr double kLongest = 1e8;  // three years; an infinite or NaN limit means none
  if (!(seconds < kLongest)) seconds = kLongest;
  return Clock::now() + std::chrono::milliseconds(static_cast<int64_t>(std::max(seconds, 0.0) * 1000));
}

std::string system_fault(const char* what) {
  return std::string(what) + ": " + std::strerror(errno);
}

std::string seconds_text(double seconds) {
  char text[32];
  std::snprintf(text, sizeof(text), "%g", seconds);
  return text;
}

Result<Ingested> run(const std::filesystem::path& path, const IngestLimits& limits,
                     const std::function<Result<Ingested>()>& work) {
  const auto fault = [&](const std::string& reason) { return file_error(path, ErrorCode::runtime, reason); };
  const Descriptor result_file(::memfd_create("vcd-ingest", MFD_CLOEXEC));
  if (result_file.get() < 0) return fault(system_fault("no memory file for the parser's result"));
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return fault(system_fault("no pipe to the parser"));
  const Descriptor words_in(ends[0]);
  Descriptor words_out(ends[1]);
  ::fcntl(words_in.get(), F_SETFL, O_NONBLOCK);

  const Clock::time_point deadline = deadline_after(limits.seconds);
  pid_t pid = 0;
  {
    const BlockedSignals blocked;
    const pid_t parent = ::getpid();
    pid = ::fork();
    if (pid == 0) live_as_child(path, limits, work, parent, result_file.get(), words_out.get());
  }
  if (pid < 0) return fault(system_fault("no process for the parser"));
  Child child(pid);
  words_out.close();

  LastWords words;
  if (!child.wait(deadline, words_in.get(), words)) {
    return fault("the parser took more than " + seconds_text(limits.seconds) + " s" + words.text());
  }
  if (const std::string end = child.fault(); !end.empty()) return fault(end + words.text());
  std::optional<Result<Ingested>> result = read_result(result_file.get());
  if (!result) return fault("the parser ended without a whole result" + words.text());
  // The bytes of the file may have had the child in their power: what it says counts no more than the file
  // itself.
  if (result->ok()) {
    if (std::optional<Error> wrong = check_ingested(path, **result)) return *std::move(wrong);
  }
  return *std::move(result);
}

}  // namespace

Result<Ingested> run_isolated(const std::filesystem::path& path, const IngestLimits& limits,
                              const std::function<Result<Ingested>()>& work) try {
  return run(path, limits, work);
} catch (const std::bad_alloc&) {
  return file_error(path, ErrorCode::runtime, "out of memory");
}

Result<Ingested> ingest_isolated(const std::filesystem::path& path, const IngestOptions& options,
                                 const IngestLimits& limits) {
  return run_isolated(path, limits, [&] { return ingest(path, options); });
}

}  // namespace vcd
