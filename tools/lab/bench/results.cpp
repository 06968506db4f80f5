#include "results.h"

#include <fstream>

#include <vcd/writer/atomic_file.h>

namespace vcd::bench {

using namespace tools;
namespace {

namespace fs = std::filesystem;

Json& entry(Json& list, const char* key, const std::string& value) {
  for (Json& item : list)
    if (item.value(key, "") == value) return item;
  list.push_back({{key, value}});
  return list.back();
}

}  // namespace

Result<Results> Results::open(const fs::path& folder, const Json& head) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) return Error{ErrorCode::io, folder.string() + ": cannot be made: " + failed.message()};
  Results results;
  results.folder_ = folder;
  const fs::path path = folder / "results.json";
  if (fs::exists(path)) {
    std::ifstream file(path);
    if (!file) return Error{ErrorCode::io, path.string() + ": cannot be read"};
    results.json_ = Json::parse(file, nullptr, false);
    if (!results.json_.is_object() || results.json_.value("tool", "") != "vc-bench" ||
        !results.json_["scenes"].is_array())
      return Error{ErrorCode::invalid_file, path.string() + ": not the results of vc-bench"};
    for (const char* key : {"format", "version", "settings", "machine"})
      if (results.json_.value(key, Json()) != head.value(key, Json()))
        return Error{ErrorCode::difference, path.string() + ": measured with other " + key + ": " +
                                                results.json_.value(key, Json()).dump() + " there, " +
                                                head.value(key, Json()).dump() + " now; give another folder with -o"};
    results.json_["command"] = head["command"];
  } else {
    results.json_ = head;
    results.json_["scenes"] = Json::array();
  }
  if (auto error = results.save()) return *error;  // an unwritable folder is found out before hours of work
  return results;
}

Json& Results::scene(const std::string& name) { return entry(json_["scenes"], "name", name); }
Json& Results::variant(Json& scene, const std::string& id) {
  if (!scene.contains("variants")) scene["variants"] = Json::array();
  return entry(scene["variants"], "id", id);
}

std::optional<Error> Results::save() const {
  const std::string text = json_.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
  AtomicFile file(folder_ / "results.json");
  file.append(std::as_bytes(std::span(text)));
  const auto written = file.commit();
  return written ? std::nullopt : std::optional(written.error());
}

}  // namespace vcd::bench
