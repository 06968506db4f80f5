// Dependencies in the form that Make and Ninja read.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include <vcd/format/error.h>

namespace vcd::tools {

// "TARGET: FILE…". Files whose names Make or Ninja would misread are named by links to them, PATH.links/1, …: they have
// the files' times. Error: io.
std::optional<Error> write_depfile(const std::filesystem::path& path, const std::filesystem::path& target,
                                   const std::vector<std::filesystem::path>& files);

}  // namespace vcd::tools
