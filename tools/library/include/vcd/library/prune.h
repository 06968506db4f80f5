// Sidecars that no asset has any more.
#pragma once

#include <filesystem>
#include <vector>

#include <vcd/library/assets.h>

namespace vcd::library {

// The sidecars below the folders of these assets that this program made and that belong to none of them: their mesh was
// removed or renamed. What cannot be read, or says of itself that another program made it, is none.
std::vector<std::filesystem::path> find_orphans(const Assets& assets);

}  // namespace vcd::library
