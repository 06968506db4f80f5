#include "json_text.h"

#include <algorithm>

#include <nlohmann/json.hpp>

namespace vcd::baker {

std::string joined(std::initializer_list<std::string_view> parts) {
  std::string text;
  for (const std::string_view part : parts) text += part;
  return text;
}

std::string json_string(std::string_view text) { return joined({"\"", text, "\""}); }

size_t JsonText::space(size_t at) const { return std::min(text_.find_first_not_of(" \t\r\n", at), text_.size()); }

// Of the value that begins there.
size_t JsonText::end_of(size_t at) const {
  size_t depth = 0;
  do {
    const char c = text_[at];
    if (c == '"') {
      for (++at; text_[at] != '"'; ++at) at += text_[at] == '\\';
      ++at;
    } else if (c == '{' || c == '[') {
      ++depth, ++at;
    } else if (c == '}' || c == ']') {
      --depth, ++at;
    } else {  // a number or a word, or what stands between values
      at = depth > 0 ? at + 1 : std::min(text_.find_first_of(",]} \t\r\n", at), text_.size());
    }
  } while (depth > 0);
  return at;
}

JsonText::Value JsonText::root() const {
  const size_t begin = space(text_.starts_with("\xEF\xBB\xBF") ? 3 : 0);
  return {begin, end_of(begin)};
}

std::optional<JsonText::Value> JsonText::member(Value object, std::string_view key) const {
  std::optional<Value> found;
  for (size_t at = space(object.begin + 1); text_[at] != '}';) {
    const Value name{at, end_of(at)};
    const size_t begin = space(space(name.end) + 1);  // behind the colon
    const Value value{begin, end_of(begin)};
    if (nlohmann::json::parse(text_of(name)) == key) found = value;
    at = space(value.end);
    if (text_[at] == ',') at = space(at + 1);
  }
  return found;
}

std::vector<JsonText::Value> JsonText::elements(Value array) const {
  std::vector<Value> values;
  for (size_t at = space(array.begin + 1); text_[at] != ']';) {
    values.push_back({at, end_of(at)});
    at = space(values.back().end);
    if (text_[at] == ',') at = space(at + 1);
  }
  return values;
}

void JsonText::add_member(Value object, std::string_view key, const std::string& json) {
  edits_.push_back(
      {{object.begin + 1, object.begin + 1}, joined({json_string(key), ":", json, is_empty(object) ? "" : ","})});
}

void JsonText::add_element(Value array, const std::string& json) {
  edits_.push_back({{array.end - 1, array.end - 1}, joined({is_empty(array) ? "" : ",", json})});
}

std::string JsonText::edited() const {
  std::vector<Edit> edits = edits_;
  std::ranges::stable_sort(edits, {}, [](const Edit& edit) { return edit.place.begin; });
  std::string text;
  size_t at = 0;
  for (const Edit& edit : edits) {
    text += text_.substr(at, edit.place.begin - at);
    text += edit.text;
    at = edit.place.end;
  }
  return text.append(text_.substr(at));
}

}  // namespace vcd::baker
