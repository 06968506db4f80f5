// Scripts that complete a program's options, words to choose from and files by their extensions, from its options.
#pragma once

#include <string>

#include "option_table.h"

namespace vcd {

std::string bash_completion(const CommandEntry& program);  // complete: share/bash-completion/completions/PROGRAM
std::string zsh_completion(const CommandEntry& program);   // _arguments: share/zsh/site-functions/_PROGRAM
std::string fish_completion(const CommandEntry& program);  // share/fish/vendor_completions.d/PROGRAM.fish

}  // namespace vcd
