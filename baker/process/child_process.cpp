#include <vcd/baker/child_process.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>
#include <string_view>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#ifndef __has_feature
#define __has_feature(x) 0
#endif
#if __has_feature(address_sanitizer) && __clang_major__ < 17
// Clang's runtime does not see to its own locks at fork before release 17: a child whose parent's other thread was
// allocating would wait forever at its own first allocation. These are the locks that release 17 takes.
namespace __lsan {
void LockAllocator();
void UnlockAllocator();
}  // namespace __lsan
namespace __sanitizer {
void StackDepotLockAll();
void StackDepotUnlockAll();
}  // namespace __sanitizer
#endif

namespace vcd::baker {
namespace {

// The sanitizers map terabytes of shadow memory.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || __has_feature(address_sanitizer) || \
    __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
constexpr bool kLimitMemory = false;
#else
constexpr bool kLimitMemory = true;
#endif

pid_t fork_process() {
#if __has_feature(address_sanitizer) && __clang_major__ < 17
  __lsan::LockAllocator();
  __sanitizer::StackDepotLockAll();
  const pid_t pid = ::fork();
  __sanitizer::StackDepotUnlockAll();
  __lsan::UnlockAllocator();
  return pid;
#else
  return ::fork();
#endif
}

constexpr size_t kMostWords = 4096;

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
  for (int number = 1; number < NSIG; ++number)
    if (::signal(number, SIG_DFL) == SIG_IGN && (number == SIGHUP || number == SIGINT))
      ::signal(number, SIG_IGN);  // as nohup and & want it of all that they start
  ::signal(SIGPIPE, SIG_IGN);     // writing to a parent that is gone is an error, not an end
  sigset_t none;
  sigemptyset(&none);
  ::pthread_sigmask(SIG_SETMASK, &none, nullptr);
}

// The bytes of private writable memory that the process has; 0 if the system does not say.
uint64_t data_bytes() {
  const Descriptor file(::open("/proc/self/statm", O_RDONLY | O_CLOEXEC));
  char text[128] = {};
  if (file.get() < 0 || ::read(file.get(), text, sizeof(text) - 1) <= 0) return 0;
  unsigned long long pages = 0;
  if (std::sscanf(text, "%*u %*u %*u %*u %*u %llu", &pages) != 1) return 0;
  return pages * static_cast<uint64_t>(::sysconf(_SC_PAGESIZE));
}

void lower_limit(__rlimit_resource resource, uint64_t value) {
  rlimit limit;
  if (::getrlimit(resource, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max = std::min<rlim_t>(value, limit.rlim_max);  // nor may its own children have more
  ::setrlimit(resource, &limit);
}

[[noreturn]] void live_as_child(const ChildLimits& limits, const std::function<int()>& work, pid_t parent, int words) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(ChildProcess::kThrew);  // it died before it could be bound to this process
  reset_signals();
  ::dup2(words, STDOUT_FILENO);
  ::dup2(words, STDERR_FILENO);
  lower_limit(RLIMIT_CORE, 0);
  const uint64_t data = data_bytes();
  if (kLimitMemory && limits.memory_bytes < UINT64_MAX - data) lower_limit(RLIMIT_DATA, data + limits.memory_bytes);
  int code = ChildProcess::kThrew;
  try {
    code = work();
  } catch (const std::bad_alloc&) {
    code = ChildProcess::kOutOfMemory;
  } catch (const std::exception& error) {
    ::dprintf(STDERR_FILENO, "%s\n", error.what());
  }
  std::fflush(nullptr);
  ::_exit(code);  // the caller's destructors are not the child's business
}

std::string printable(std::string_view line) {
  constexpr size_t kLongest = 200;
  std::string text;
  for (const char c : line.substr(0, kLongest)) text += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  return text;
}

std::string number_text(double number) {
  char text[32];
  std::snprintf(text, sizeof(text), "%g", number);
  return text;
}

std::chrono::milliseconds allowed(double seconds) {
  constexpr double kLongest = 1e8;  // three years
  if (!(seconds < kLongest)) seconds = kLongest;
  return std::chrono::milliseconds(static_cast<int64_t>(std::max(seconds, 0.0) * 1000));
}

Error system_error(const char* what) { return {ErrorCode::runtime, std::string(what) + ": " + std::strerror(errno)}; }

}  // namespace

Descriptor::Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  std::swap(number_, other.number_);
  return *this;
}
void Descriptor::close() {
  if (number_ >= 0) ::close(number_);
  number_ = -1;
}

Result<ChildProcess> ChildProcess::start(const ChildLimits& limits, const std::function<int()>& work) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return system_error("no pipe to a child process");
  Descriptor words_in(ends[0]);
  const Descriptor words_out(ends[1]);
  ::fcntl(words_in.get(), F_SETFL, O_NONBLOCK);
  std::fflush(nullptr);  // or the child prints it once more
  const Clock::time_point deadline = Clock::now() + allowed(limits.seconds);
  pid_t pid = 0;
  {
    const BlockedSignals blocked;
    const pid_t parent = ::getpid();
    pid = fork_process();
    if (pid == 0) live_as_child(limits, work, parent, words_out.get());
  }
  if (pid < 0) return system_error("no child process");
  return ChildProcess(pid, std::move(words_in), limits, deadline);
}

ChildProcess::ChildProcess(pid_t pid, Descriptor words, const ChildLimits& limits, Clock::time_point deadline)
    : pid_(pid), words_(std::move(words)), limits_(limits), deadline_(deadline) {}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : pid_(other.pid_),
      words_(std::move(other.words_)),
      limits_(other.limits_),
      deadline_(other.deadline_),
      kept_(std::move(other.kept_)),
      status_(other.status_),
      peak_memory_bytes_(other.peak_memory_bytes_),
      ended_(std::exchange(other.ended_, true)),
      out_of_time_(other.out_of_time_) {}

ChildProcess::~ChildProcess() { kill(); }

void ChildProcess::drain() {
  char chunk[4096];
  while (words_.get() >= 0) {
    const ssize_t got = ::read(words_.get(), chunk, sizeof(chunk));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0 && errno == EAGAIN) return;
    if (got <= 0) return words_.close();
    kept_.append(chunk, static_cast<size_t>(got));
    if (kept_.size() > 2 * kMostWords) kept_.erase(0, kept_.size() - kMostWords);
  }
}

bool ChildProcess::reaped(int options) {
  rusage usage{};
  pid_t got;
  while ((got = ::wait4(pid_, &status_, options, &usage)) < 0 && errno == EINTR) {
  }
  if (got == pid_) peak_memory_bytes_ = static_cast<uint64_t>(usage.ru_maxrss) * 1024;
  // ECHILD: the caller ignores SIGCHLD, so that the kernel reaps. Then only the result can tell how it ended.
  return got == pid_ || (got < 0 && errno == ECHILD);
}

bool ChildProcess::update() {
  if (ended_) return true;
  if (reaped(WNOHANG)) {
    drain();
    return ended_ = true;
  }
  drain();
  if (Clock::now() < deadline_) return false;
  out_of_time_ = true;
  kill();
  return true;
}

void ChildProcess::wait() {
  while (!update()) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline_ - Clock::now()).count();
    // The pipe closes when the child ends, unless another thread forked meanwhile and holds its other end too: hence
    // the short naps. Once it is closed there is nothing to poll.
    pollfd waiting = {words_.get(), POLLIN, 0};
    ::poll(&waiting, 1, static_cast<int>(std::clamp<int64_t>(left, 0, words_.get() >= 0 ? 20 : 1)));
  }
}

void ChildProcess::kill() {
  if (ended_) return;
  ::kill(pid_, SIGKILL);
  reaped(0);
  ended_ = true;
  drain();
}

int ChildProcess::exit_code() const { return WIFEXITED(status_) ? WEXITSTATUS(status_) : -1; }

bool ChildProcess::out_of_memory() const { return exit_code() == kOutOfMemory; }

std::string ChildProcess::fault() const {
  if (out_of_time_) return "took more than " + number_text(limits_.seconds) + " s";
  if (out_of_memory())
    return "ran out of memory (limit " + number_text(std::round(static_cast<double>(limits_.memory_bytes) / 1048576)) +
           " MiB)";
  if (WIFSIGNALED(status_)) {
    const int number = WTERMSIG(status_);
    const char* name = ::sigabbrev_np(number);
    // Nobody else kills with this one but the kernel, for want of memory, or an impatient user.
    if (number == SIGKILL) return "was killed (SIGKILL), perhaps for want of memory";
    return "crashed (" + (name == nullptr ? "signal " + std::to_string(number) : std::string("SIG") + name) + ")";
  }
  if (exit_code() == kThrew) return "failed";
  return exit_code() == 0 ? "" : "ended before its time (exit status " + std::to_string(exit_code()) + ")";
}

std::string ChildProcess::last_words() const {
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

}  // namespace vcd::baker
