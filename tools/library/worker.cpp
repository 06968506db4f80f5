#include <vcd/library/worker.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include <tbb/global_control.h>

#include <vcd/library/bake_asset.h>
#include "common/paths.h"
#include "common/seconds_since.h"

namespace vcd::library {

using namespace baker;
namespace {

using namespace tools;

namespace fs = std::filesystem;

constexpr size_t kLongestMessage = size_t{64} << 20;

// Messages are JSON objects, one a line: {"stage"}, {"fraction", "rays", "seconds"}, and the last one either the
// members of BakedAsset or {"code", "error"}.
void send(int pipe, const Json& message) {
  const std::string line = json_text(message) + "\n";
  for (size_t sent = 0; sent < line.size();) {
    const ssize_t wrote = ::write(pipe, line.data() + sent, line.size() - sent);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote <= 0) return;  // the parent is gone, and so will this process be
    sent += static_cast<size_t>(wrote);
  }
}

// An eighth is left to pages that are not a process's own: the parser's result on its way, tables of the system.
uint64_t own_bytes(const WorkerOptions& options) { return options.memory_bytes / 8 * 7; }

double parser_seconds(const fs::path& input) {
  std::error_code error;
  const auto size = fs::file_size(input, error);
  return 60 + (error ? 0 : static_cast<double>(size) * 1e-6);
}

// A message says anything: members of another type are as if they were not there.
std::optional<BakedAsset> baked_asset(const Json& message) {
  const auto number = [&](const char* key) {
    return message.contains(key) && message[key].is_number_unsigned() ? message[key].get<uint64_t>() : 0;
  };
  const auto list = [&](const char* key) {
    return message.contains(key) && message[key].is_array() ? message[key] : Json::array();
  };
  if (!message.contains("report") || !message["report"].is_object()) return std::nullopt;
  if (!message.contains("summary") || !message["summary"].is_string()) return std::nullopt;
  BakedAsset baked;
  baked.bytes = number("bytes");
  baked.objects_reused = number("objects_reused");
  for (const Json& note : list("notes"))
    if (note.is_string()) baked.notes.push_back(note.get<std::string>());
  baked.summary = message["summary"].get<std::string>();
  baked.report = json_text(message["report"]);
  for (const Json& source : list("sources"))
    if (auto path = path_from_json(source)) baked.sources.push_back(std::move(*path));
  for (const Json& object : list("wanted")) {
    const auto is_count = [&](size_t i) { return object[i].is_number_unsigned(); };
    if (!object.is_array() || object.size() < 2 || !is_count(0) || !is_count(1)) return std::nullopt;
    WantedBytes& wanted = baked.wanted.emplace_back(WantedBytes{object[0].get<uint64_t>()});
    wanted.depth = object[1].get<uint32_t>();
    for (size_t i = 2; i + 1 < object.size(); i += 2) {
      if (!is_count(i) || !object[i + 1].is_number()) return std::nullopt;
      wanted.worth.push_back({object[i].get<uint64_t>(), object[i + 1].get<double>()});
    }
  }
  return baked;
}

// Embree maps 128 MiB that it hardly touches: they count as the process's data and take no memory.
constexpr uint64_t kUntouchedBytes = uint64_t{144} << 20;

int bake_and_send(const Asset& asset, const WorkerOptions& options, int pipe) {
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, options.threads);
  BakeContext context{options.threads,
                      options.cache,
                      options.reuse,
                      options.measure,
                      {parser_seconds(asset.input), own_bytes(options)}};
  context.on_stage = [&](const std::string& stage) { send(pipe, {{"stage", stage}}); };
  double last = -1;
  context.on_progress = [&](const BakeProgress& p) {
    if (p.seconds - last < 0.1) return;
    last = p.seconds;
    send(pipe, {{"fraction", p.fraction}, {"rays", p.rays}, {"seconds", p.seconds}});
  };
  const auto baked = bake_asset(asset, context);
  if (!baked && baked.error().code == ErrorCode::runtime &&
      baked.error().message.find("out of memory") != std::string::npos)
    return ChildProcess::kOutOfMemory;
  if (!baked) return send(pipe, {{"code", static_cast<int>(baked.error().code)}, {"error", baked.error().message}}), 0;
  Json sources = Json::array();
  for (const fs::path& source : baked->sources) sources.push_back(path_to_json(source));
  Json wanted = Json::array();
  for (const WantedBytes& object : baked->wanted) {
    Json numbers = Json::array({object.least, object.depth});  // then bytes and their worth, pair by pair
    for (const WorthOfBytes& w : object.worth) numbers.push_back(w.bytes), numbers.push_back(w.asked_a_byte);
    wanted.push_back(std::move(numbers));
  }
  send(pipe, {{"bytes", baked->bytes},
              {"objects_reused", baked->objects_reused},
              {"notes", baked->notes},
              {"summary", baked->summary},
              {"report", Json::parse(baked->report)},
              {"sources", sources},
              {"wanted", wanted}});
  return 0;
}

}  // namespace

const char* error_kind(ErrorCode code) {
  switch (code) {
    case ErrorCode::usage: return "usage";
    case ErrorCode::io: return "io";
    case ErrorCode::invalid_file: return "invalid-file";
    case ErrorCode::runtime: return "runtime";
    case ErrorCode::unsupported: return "unsupported";
    case ErrorCode::difference: return "difference";
    case ErrorCode::stale: return "stale";
  }
  return "runtime";
}

Result<Worker> Worker::start(const Asset& asset, const WorkerOptions& options) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0)
    return Error{ErrorCode::runtime, shown(asset.input) + ": no pipe: " + std::strerror(errno)};
  Descriptor in(ends[0]);
  const Descriptor out(ends[1]);
  ::fcntl(in.get(), F_SETFL, O_NONBLOCK);
  const double seconds = options.seconds > 0 ? options.seconds : std::numeric_limits<double>::infinity();
  auto child = ChildProcess::start({seconds, own_bytes(options) + kUntouchedBytes}, [&] {
    in.close();
    return bake_and_send(asset, options, out.get());
  });
  if (!child) return Error{ErrorCode::runtime, shown(asset.input) + ": " + child.error().message};
  return Worker(asset, std::move(*child), std::move(in));
}

Worker::Worker(const Asset& asset, ChildProcess child, Descriptor messages)
    : input_(asset.input), child_(std::move(child)), messages_(std::move(messages)) {}

double Worker::seconds() const { return seconds_since(start_); }

void Worker::take(const std::string& line) {
  const Json message = Json::parse(line, nullptr, /*allow_exceptions=*/false);
  if (!message.is_object()) return;
  const auto number = [&](const char* key, double& value) {
    if (message.contains(key) && message[key].is_number() && std::isfinite(message[key].get<double>()))
      value = message[key].get<double>();
  };
  if (message.contains("stage") && message["stage"].is_string()) {
    stage_ = message["stage"].get<std::string>();
    fraction_ = 0;
  } else if (message.contains("fraction")) {
    number("fraction", fraction_), number("rays", rays_), number("seconds", bake_seconds_);
  } else {
    result_ = line;
  }
}

bool Worker::update() {
  const bool ended = child_.update();
  char chunk[65536];
  while (messages_.get() >= 0) {
    const ssize_t got = ::read(messages_.get(), chunk, sizeof chunk);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0 && errno == EAGAIN) break;
    if (got <= 0 || unread_.size() > kLongestMessage) {
      messages_.close();
      break;
    }
    unread_.append(chunk, static_cast<size_t>(got));
    for (size_t end; (end = unread_.find('\n')) != std::string::npos; unread_.erase(0, end + 1))
      take(unread_.substr(0, end));
  }
  return ended;
}

Outcome Worker::outcome() const {
  Outcome outcome;
  outcome.stage = stage_;
  const Json result = Json::parse(result_, nullptr, /*allow_exceptions=*/false);
  if (const std::string fault = child_.fault(); !fault.empty()) {
    outcome.code = static_cast<int>(ErrorCode::runtime);
    outcome.kind = child_.out_of_time() ? "time" : child_.out_of_memory() ? "memory" : "crash";
    outcome.message = shown(input_) + ": " + fault + " while " + stage_ + child_.last_words();
  } else if (result.contains("error") && result["error"].is_string() && result.contains("code") &&
             result["code"].is_number_integer()) {
    outcome.code = std::clamp(result["code"].get<int>(), 1, 8);
    outcome.kind = error_kind(static_cast<ErrorCode>(outcome.code));
    outcome.message = result["error"].get<std::string>();
  } else if (auto baked = baked_asset(result)) {
    outcome.baked = std::move(*baked);
  } else {
    outcome.code = static_cast<int>(ErrorCode::runtime);
    outcome.kind = "crash";
    outcome.message = shown(input_) + ": ended without a result while " + stage_ + child_.last_words();
  }
  return outcome;
}

}  // namespace vcd::library
