#include <charconv>
#include <cmath>
#include <filesystem>

#include "paper_run.h"

namespace vcd::bench {

using namespace tools;
using namespace render;
namespace {

template <class Number>
bool set_number(const std::string& text, Number& target) {
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), target);
  return failure == std::errc{} && end == text.data() + text.size();
}

// What may stand in a file's name and in an element's id, wherever it is shown.
constexpr const char* kNameCharacters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-";

bool set_option(const std::string& key, const std::string& value, SceneOptions& o) {
  if (key == "up") return value.size() == 1 && value[0] >= 'x' && value[0] <= 'z' && (o.up = value[0], true);
  if (key == "turn") return set_number(value, o.turn_degrees) && std::abs(o.turn_degrees) <= 3600;
  if (key == "level") return set_number(value, o.generated.level) && o.generated.level <= 12;
  if (key == "strands") return set_number(value, o.generated.hairball.strands) && o.generated.hairball.strands > 0;
  if (key == "segments") return set_number(value, o.generated.hairball.segments) && o.generated.hairball.segments > 0;
  if (key == "sides") return set_number(value, o.generated.hairball.sides) && o.generated.hairball.sides >= 3;
  if (key == "instances") return set_number(value, o.generated.forest.instances) && o.generated.forest.instances > 0;
  if (key == "species")
    return set_number(value, o.generated.forest.species) && o.generated.forest.species >= 1 &&
           o.generated.forest.species <= 4;
  if (key == "seed")
    return set_number(value, o.generated.hairball.seed) && (o.generated.forest.seed = o.generated.hairball.seed, true);
  if (key == "leaves") return set_number(value, o.generated.forest.leaves) && o.generated.forest.leaves > 0;
  return false;
}

}  // namespace

Result<SceneRequest> parse_scene_request(const std::string& text, const SceneOptions& defaults) {
  SceneRequest request{"", {}, defaults};
  std::string head = text;
  while (true) {  // options from the back, as long as they are options: a file's name may hold commas
    const size_t comma = head.rfind(',');
    const size_t equals = comma == std::string::npos ? comma : head.find('=', comma);
    if (equals == std::string::npos) break;
    const std::string key = head.substr(comma + 1, equals - comma - 1), value = head.substr(equals + 1);
    if (!set_option(key, value, request.options))
      return Error{ErrorCode::usage,
                   text + ": \"" + key + "=" + value +
                       "\" is not one of up, turn, level, strands, segments, sides, instances, species, leaves, seed "
                       "with a value in range"};
    head.resize(comma);
  }
  const size_t equals = head.find('=');
  const std::string source = equals == std::string::npos ? head : head.substr(equals + 1);
  request.name = equals == std::string::npos ? std::filesystem::path(source).stem().string() : head.substr(0, equals);
  if (source.empty() || request.name.empty() || request.name.find_first_not_of(kNameCharacters) != std::string::npos ||
      request.name[0] == '.' || request.name[0] == '-' || request.name[0] == '_')
    return Error{
        ErrorCode::usage,
        text + ": not [NAME=]SCENE|MESH[,KEY=VALUE]... with a name of letters, digits, dots, dashes and underscores"};
  request.source = {source};
  return request;
}

}  // namespace vcd::bench
