#pragma once

#include <string_view>

namespace vcd {

bool is_utf8(std::string_view text);

}  // namespace vcd
