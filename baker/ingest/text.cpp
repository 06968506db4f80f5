#include "ingest/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

namespace vcd::baker {
namespace {

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f' || c == '\r' || c == '\n'; }

// std::from_chars knows no '+'; a sign may not follow it.
std::string_view without_plus(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-' && word[1] != '+') word.remove_prefix(1);
  return word;
}

}  // namespace

std::string_view without_byte_order_mark(std::string_view text) {
  return text.starts_with("\xEF\xBB\xBF") ? text.substr(3) : text;
}

bool is_wide_text(std::string_view text) {
  return text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF") ||
         text.substr(0, 4).find('\0') != std::string_view::npos;
}

bool LineReader::next(std::string_view& line) {
  if (offset_ >= text_.size()) return false;
  const size_t end = std::min(text_.find_first_of("\r\n", offset_), text_.size());
  line = text_.substr(offset_, end - offset_);
  offset_ = end + (text_.substr(end, 2) == "\r\n" ? 2 : 1);
  offset_ = std::min(offset_, text_.size());
  ++number_;
  return true;
}

std::string_view Words::next() {
  size_t begin = 0;
  while (begin < rest_.size() && is_space(rest_[begin])) ++begin;
  size_t end = begin;
  while (end < rest_.size() && !is_space(rest_[end])) ++end;
  const std::string_view word = rest_.substr(begin, end - begin);
  rest_.remove_prefix(end);
  return word;
}

std::optional<float> parse_float(std::string_view word) {
  word = without_plus(word);
  float value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size()) return std::nullopt;
  if (error == std::errc()) return value;
  if (error != std::errc::result_out_of_range) return std::nullopt;
  // Out of a float's range: zero or infinity? from_chars does not say, but the wider double mostly does.
  double wide = 0;
  if (std::from_chars(word.data(), word.data() + word.size(), wide).ec == std::errc()) {
    return static_cast<float>(wide);
  }
  // Out of a double's range too. So few digits with a negative exponent can only be too small.
  const bool tiny = word.size() < 40 && word.find_first_of("eE") != std::string_view::npos &&
                    word[word.find_first_of("eE") + 1] == '-';
  return tiny ? 0.0f : std::numeric_limits<float>::infinity();
}

std::optional<int64_t> parse_integer(std::string_view word) {
  word = without_plus(word);
  int64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

std::string parse_coordinate(std::string_view word, Coordinate& value) {
  if (word.empty()) return "fewer than three coordinates";
  const std::string_view number = without_plus(word);
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value.value);
  const bool wide = error == std::errc() && end == number.data() + number.size();
  if (wide) value.nearest = static_cast<float>(value.value);
  // Rounded twice, a number may come out as another float if its double lies midway between two.
  const double below = value.nearest,
               above = std::nextafter(value.nearest, value.value > below ? HUGE_VALF : -HUGE_VALF);
  if (!wide || !std::isfinite(above) || value.value - below == above - value.value) {
    const std::optional<float> parsed = parse_float(word);
    if (!parsed) return in_quotes(word) + " is not a number";
    value.nearest = *parsed;
    if (!wide) value.value = *parsed;
  }
  if (!std::isfinite(value.nearest)) return in_quotes(word) + " is not finite as a 32-bit float";
  return "";
}

std::string parse_position(Words& words, Coordinates& position) {
  for (Coordinate& coordinate : position) {
    std::string reason = parse_coordinate(words.next(), coordinate);
    if (!reason.empty()) return reason;
  }
  return "";
}

std::string in_quotes(std::string_view word) {
  constexpr size_t kLongest = 40;
  std::string text = "\"";
  for (const char c : word.substr(0, kLongest)) text += c >= 0x20 && c != 0x7F ? c : '?';
  return text + (word.size() > kLongest ? "…\"" : "\"");
}

std::string counted(uint64_t count, const std::string& noun, const std::string& plural) {
  return std::to_string(count) + " " + (count == 1 ? noun : plural.empty() ? noun + "s" : plural);
}

}  // namespace vcd::baker
