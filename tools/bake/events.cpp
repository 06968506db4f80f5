#include "events.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include <unistd.h>

#include "bake/report.h"
#include "common/paths.h"

namespace vcd::tools {

using namespace library;

namespace {

// As AtomicFile does, so too here: no file is overwritten through a link. /dev/stdout leads to none.
bool leads_to_a_file(const std::string& path) {
  std::error_code error;
  return std::filesystem::is_symlink(path, error) &&
         (!std::filesystem::exists(path, error) || std::filesystem::is_regular_file(path, error));
}

}  // namespace

Result<Events> Events::open(const std::string& path, bool go_on) {
  if (leads_to_a_file(path)) return Error{ErrorCode::io, shown(path) + ": is a link; nothing is written through it"};
  Events events;
  if (path == "-") events.file_.reset(stdout);
  else if (!path.empty()) events.file_.reset(std::fopen(path.c_str(), go_on ? "ae" : "we"));
  if (go_on && events.file_ && std::ftell(events.file_.get()) > 0)
    std::fputc('\n', events.file_.get());  // a run that was killed may have left half a line
  if (!path.empty() && !events.file_) return Error{ErrorCode::io, shown(path) + ": " + std::strerror(errno)};
  return events;
}

void Events::say(const Json& event) {
  if (!file_) return;
  const std::string line = json_text(event) + "\n";
  std::fwrite(line.data(), 1, line.size(), file_.get());
  std::fflush(file_.get());
}

void Events::attempt_started(const Asset& asset, const library::Grant& grant) {
  say({{"event", "started"},
       {"input", path_to_json(asset.input)},
       {"threads", grant.threads},
       {"memory_bytes", grant.memory_bytes}});
}

void Events::ended(const Asset& asset, const Record& record) {
  if (!file_) return;
  Json event{{"event", "ended"}};
  event.update(record_json(asset, record));
  event.erase("objects");
  if (record.fate == Fate::failed && record.outcome.kind != "io") event["key"] = failure_key(asset);
  say(event);
}

std::map<std::string, Outcome> earlier_failures(const std::string& path) {
  std::map<std::string, Outcome> failures;
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return failures;  // -, a pipe: they keep nothing
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const Json event = Json::parse(line, nullptr, /*allow_exceptions=*/false);
    if (!event.is_object() || !event.contains("key") || !event["key"].is_string()) continue;
    const auto text = [&](const char* name) {
      return event.contains(name) && event[name].is_string() ? event[name].get<std::string>() : "";
    };
    const std::string key = text("key");
    if (key.empty() || !event.contains("exit_code") || !event["exit_code"].is_number_integer()) continue;
    Outcome outcome;
    outcome.code = event["exit_code"].get<int>();
    outcome.kind = text("kind"), outcome.message = text("error"), outcome.stage = text("stage");
    failures[key] = outcome;
  }
  return failures;
}

}  // namespace vcd::tools
