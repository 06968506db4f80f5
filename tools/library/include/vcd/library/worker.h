// A child process that bakes one asset and tells its parent how far it is and what came of it.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include <vcd/baker/child_process.h>

#include <vcd/library/bake_asset.h>

namespace vcd::library {

struct WorkerOptions {
  unsigned threads = 1;
  double seconds = 0;         // wall time; 0: no limit
  uint64_t memory_bytes = 0;  // of the worker and its parser together
  std::filesystem::path cache;
  bool reuse = false;
  bool measure = false;  // BakeContext::measure
};

// How a worker ended.
struct Outcome {
  int code = 0;      // exit code of the program were this its only asset
  std::string kind;  // "" if it was baked; else what failed: "crash", "time", "memory", or the name of the error code,
                     // "invalid-file"
  std::string message;  // likewise; names the file, the place and the reason
  std::string stage;    // what it was doing at its end
  BakedAsset baked;     // if it was baked

  bool ok() const { return code == 0; }
};

const char* error_kind(ErrorCode code);

// Dies with its parent; killed and reaped when this goes. What it says is not believed beyond its form: the asset's
// bytes may have had it in their power.
class Worker {
 public:
  // Error (runtime): no process. The caller has no other threads.
  static Result<Worker> start(const Asset& asset, const WorkerOptions& options);

  int messages() const { return messages_.get(); }  // to poll; -1 once it has said all
  int words() const { return child_.words(); }
  bool update();            // takes in what it says; true once it has ended
  Outcome outcome() const;  // then

  const std::string& stage() const { return stage_; }
  double fraction() const { return fraction_; }  // of the object that is being baked
  double rays() const { return rays_; }
  double bake_seconds() const { return bake_seconds_; }
  double seconds() const;                                                    // since its start
  uint64_t peak_memory_bytes() const { return child_.peak_memory_bytes(); }  // after its end

 private:
  Worker(const Asset& asset, baker::ChildProcess child, baker::Descriptor messages);
  void take(const std::string& line);

  std::filesystem::path input_;
  baker::ChildProcess child_;
  baker::Descriptor messages_;
  std::string unread_;
  std::string stage_ = "starting";
  double fraction_ = 0, rays_ = 0, bake_seconds_ = 0;
  std::string result_;  // the last message
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace vcd::library
