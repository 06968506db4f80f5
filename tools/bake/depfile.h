// Dependencies in the form that Make and Ninja read.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include <vcd/format/error.h>

namespace vcd::tools {

// "TARGET: FILE…". Error: io; unsupported for names with a line end, which no such file can say.
std::optional<Error> write_depfile(const std::filesystem::path& path, const std::filesystem::path& target,
                                   const std::vector<std::filesystem::path>& files);

}  // namespace vcd::tools
