// A JSON text to which members and elements are added, every other byte kept.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vcd::baker {

std::string joined(std::initializer_list<std::string_view> parts);
std::string json_string(std::string_view text);  // which needs no escapes

class JsonText {
 public:
  // text: well-formed, as a parser has found. Outlives this.
  explicit JsonText(std::string_view text) : text_(text) {}

  struct Value {
    size_t begin, end;
  };
  Value root() const;
  // The last one of that name, as parsers take it. object is one.
  std::optional<Value> member(Value object, std::string_view key) const;
  std::vector<Value> elements(Value array) const;  // array is one
  std::string_view text_of(Value value) const { return text_.substr(value.begin, value.end - value.begin); }

  void add_member(Value object, std::string_view key, const std::string& json);
  void add_element(Value array, const std::string& json);
  void replace(Value value, const std::string& json) { edits_.push_back({value, json}); }

  std::string edited() const;

 private:
  struct Edit {
    Value place;
    std::string text;
  };
  bool is_empty(Value value) const { return space(value.begin + 1) == value.end - 1; }
  size_t space(size_t at) const;  // behind white space
  size_t end_of(size_t at) const;

  std::string_view text_;
  std::vector<Edit> edits_;
};

}  // namespace vcd::baker
