#pragma once

#include <string>
#include <string_view>

namespace vcd {

bool is_utf8(std::string_view text);

// The text with every byte that makes it ill-formed replaced by U+FFFD. File names can be anything.
std::string make_utf8(std::string_view text);

}  // namespace vcd
