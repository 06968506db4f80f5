#pragma once

#include <filesystem>

namespace vcd::farm {

// Of the running program's file: its siblings are started from there.
inline std::filesystem::path program_folder() { return std::filesystem::read_symlink("/proc/self/exe").parent_path(); }

}  // namespace vcd::farm
