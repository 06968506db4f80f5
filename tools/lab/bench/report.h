// Results → the page.
#pragma once

#include <filesystem>

namespace vcd::bench {

// Runs the report's Python script on a folder with results.json, and returns its exit code. The script is found beside
// the program (../share/vcd/report), in a build folder as in an installation; Python is $VCD_PYTHON, else the system's.
int write_report(const std::filesystem::path& folder);

}  // namespace vcd::bench
