// A piece of work in a forked child process with limits, so that work which crashes, hangs or floods memory costs
// itself alone.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

#include <vcd/format/error.h>

namespace vcd::baker {

struct ChildLimits {
  double seconds = 60;  // wall time; infinite or NaN: none
  // Private writable memory beyond what the caller has at the fork (RLIMIT_DATA): heaps, stacks, private maps. Not
  // counted: what the program itself and files in place take. Not applied under sanitizers.
  uint64_t memory_bytes = uint64_t{8} << 30;
};

// A file descriptor that is closed with its owner.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept;
  Descriptor& operator=(Descriptor&& other) noexcept;
  ~Descriptor() { close(); }

  int get() const { return number_; }
  void close();

 private:
  int number_ = -1;
};

// The child as its parent sees it. The child dies with the thread that started it, dumps no core, and what it prints to
// stdout or stderr is kept here instead. Killed and reaped when this goes, if it has not ended by then, so no zombie is
// left.
//
// One thread at a time. The work must not need the caller's other threads or locks that they may hold (malloc and stdio
// are fine: glibc sees to them at fork).
class ChildProcess {
 public:
  // Runs `work` in a child; its return value is the exit code. Bad allocations end in kOutOfMemory, other exceptions in
  // kThrew, with their text as last words. Descriptors without FD_CLOEXEC and those with it are open in the child:
  // nothing is executed. Error (runtime): the system has no process or pipe.
  static Result<ChildProcess> start(const ChildLimits& limits, const std::function<int()>& work);
  static constexpr int kOutOfMemory = 112, kThrew = 113;

  ChildProcess(ChildProcess&&) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;
  ~ChildProcess();

  pid_t pid() const { return pid_; }
  int words() const { return words_.get(); }  // to poll: readable when the child printed; -1 once it is closed

  // Reads what the child printed, kills it if its time is over, reaps it if it has ended. True once it has ended.
  bool update();
  // Waits until update() is true.
  void wait();
  void kill();

  // After the end. Empty if it ended with exit code 0; else a clause such as "crashed (SIGSEGV)", "took more than 60
  // s", "was killed (SIGKILL), perhaps for want of memory", "ran out of memory (limit 512 MiB)", "ended before its time
  // (exit status 3)".
  std::string fault() const;
  int exit_code() const;       // -1 if a signal ended it
  bool out_of_memory() const;  // as far as can be told
  bool out_of_time() const { return out_of_time_; }
  uint64_t peak_memory_bytes() const {
    return peak_memory_bytes_;
  }  // resident, of it or of the largest of its own children
  // The last two lines that say something, ready to end a message: ": …"; empty if there are none.
  std::string last_words() const;

 private:
  using Clock = std::chrono::steady_clock;
  ChildProcess(pid_t pid, Descriptor words, const ChildLimits& limits, Clock::time_point deadline);
  void drain();
  bool reaped(int options);

  pid_t pid_;
  Descriptor words_;
  ChildLimits limits_;
  Clock::time_point deadline_;
  std::string kept_;
  int status_ = 0;
  uint64_t peak_memory_bytes_ = 0;
  bool ended_ = false;
  bool out_of_time_ = false;
};

}  // namespace vcd::baker
