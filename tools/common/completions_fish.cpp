#include "completions.h"

#include <sstream>

namespace vcd {
namespace {

constexpr const char* kFiles = R"fish(
function __vcd_files  # EXTENSION...: folders, and the files that end so, in any case
    set -l ends '/' '\.'$argv
    set -l begun (string replace -r -- '^--[^=]*=' '' (commandline -ct))
    __fish_complete_path $begun | string match -eri '(?:'(string join '|' $ends)')(?:\t|$)'
end
)fish";

std::string in_quotes(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\' || c == '\'') out += '\\';
    out += c;
  }
  return "'" + out + "'";
}

// What to choose from, as arguments of complete.
std::string choices(const ValueEntry& value) {
  std::string words = joined(value.words);
  if (value.comma_list && !words.empty()) words = joined({"(__fish_append ,", words, ")"});
  if (!words.empty() && value.files != Files::none) words += ' ';
  if (value.files != Files::none && value.files != Files::any)
    words.append("(__vcd_files ").append(joined(extensions_of(value.files))).append(")");
  return words.empty() ? words : " -a " + in_quotes(words);
}

void write_options(std::ostream& out, const std::string& begin, const std::vector<OptionEntry>& options) {
  for (const OptionEntry& option : options) {
    out << begin;
    for (const std::string& name : option.names)
      out << (name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1));
    if (option.takes_value) out << (option.value.files == Files::any ? " -r -F" : " -x") << choices(option.value);
    out << " -d " << in_quotes(option.description) << '\n';
  }
}

void write_positionals(std::ostream& out, const std::string& begin, const std::vector<OptionEntry>& positionals) {
  for (const OptionEntry& positional : positionals)
    if (const std::string some = choices(positional.value); !some.empty()) out << begin << some << '\n';
}

}  // namespace

std::string fish_completion(const CommandEntry& program) {
  std::ostringstream out;
  const std::string begin = "complete -c " + program.name;
  out << "# Completion of " << program.name << " in fish. Made by " << program.name << " --print-completion fish.\n"
      << kFiles << '\n'
      << begin << " -f\n";
  write_options(out, begin, program.options);
  write_positionals(out, begin, program.positionals);
  std::vector<std::string> names;
  for (const CommandEntry& command : program.subcommands) names.push_back(command.name);
  for (const CommandEntry& command : program.subcommands) {
    out << begin << " -n " << in_quotes("not __fish_seen_subcommand_from " + joined(names)) << " -a " << command.name
        << " -d " << in_quotes(command.description) << '\n';
    const std::string after = begin + " -n " + in_quotes("__fish_seen_subcommand_from " + command.name);
    write_options(out, after, command.options);
    write_positionals(out, after, command.positionals);
  }
  return out.str();
}

}  // namespace vcd
