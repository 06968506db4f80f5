// Other programs, by their names and arguments and without a shell.
#pragma once

#include <string>
#include <vector>

#include <vcd/format/error.h>

namespace vcd::farm {

// What the program prints to standard output, once it has ended with exit code 0. Error (runtime): it is not there, or
// ended otherwise; with its words.
Result<std::string> output_of(const std::vector<std::string>& command);

// Runs it with this program's own standard output and error; it gets SIGTERM when `interrupted`, and when this process
// is killed. Its exit code, or 128 + the signal that ended it; that of ErrorCode::runtime if it is not there. One
// thread.
Result<int> run_command(const std::vector<std::string>& command);

// As a word of a shell script.
std::string shell_word(const std::string& text);

}  // namespace vcd::farm
