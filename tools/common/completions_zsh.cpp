#include "completions.h"

#include <algorithm>
#include <sstream>

namespace vcd {
namespace {

// A backslash before each of these, for _arguments.
std::string escaped(const std::string& text, const std::string& special) {
  std::string out;
  for (const char c : text) {
    if (special.find(c) != std::string::npos) out += '\\';
    out += c;
  }
  return out;
}

std::string in_quotes(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return "'" + out + "'";
}

std::string files_action(Files files) {
  if (files == Files::any) return "_files";
  if (files == Files::folders) return "_files -/";
  std::vector<std::string> patterns;  // in any case
  for (const std::string& extension : extensions_of(files)) patterns.push_back("(#i)*." + extension);
  return joined({"_files -g \"", joined(patterns), "\""}, "");
}

std::string action(const ValueEntry& value) {
  if (value.words.empty()) return value.files == Files::none ? " " : files_action(value.files);
  const std::string words = joined(value.words);
  if (value.files != Files::none)
    return joined({"{_alternative \"words\\:word\\:(", words, ")\" 'files\\:file\\:", files_action(value.files), "'}"},
                  "");
  return value.comma_list ? joined({"_values -s , value", words}) : joined({"(", words, ")"}, "");
}

// ":message:action"
std::string argument(const ValueEntry& value) { return joined({"", escaped(value.text, "\\:"), action(value)}, ":"); }

// One specification for each name: "(-o --output)--output=[Where to]:PATH:_files".
void write_options(std::ostream& out, const std::string& indent, const std::vector<OptionEntry>& options) {
  for (const OptionEntry& option : options) {
    for (const std::string& name : option.names) {
      std::ostringstream spec;
      if (option.repeated) spec << '*';
      else spec << '(' << joined(option.names) << ')';
      spec << name;
      if (option.takes_value) spec << (name.starts_with("--") ? '=' : '+');
      spec << '[' << escaped(option.description, "\\[]:") << ']';
      if (option.takes_value) spec << argument(option.value);
      out << indent << in_quotes(spec.str()) << " \\\n";
    }
  }
}

void write_positionals(std::ostream& out, const std::string& indent, const std::vector<OptionEntry>& positionals) {
  int place = 0;
  for (const OptionEntry& positional : positionals) {
    ++place;
    out << indent << in_quotes((positional.repeated ? "*" : std::to_string(place)) + argument(positional.value))
        << " \\\n";
  }
}

void write_subcommands(std::ostream& out, const CommandEntry& program) {
  out << "  case $state in\n    command)\n      local -a commands=(\n";
  for (const CommandEntry& command : program.subcommands)
    out << "        " << in_quotes(command.name + ":" + escaped(command.description, "\\:")) << '\n';
  out << "      )\n      _describe command commands && ret=0 ;;\n    argument)\n      case $words[1] in\n";
  for (const CommandEntry& command : program.subcommands) {
    out << "        " << command.name << ")\n          _arguments -S \\\n";
    write_options(out, "            ", options_after(program, command));
    write_positionals(out, "            ", command.positionals);
    out << "            && ret=0 ;;\n";
  }
  out << "      esac ;;\n  esac\n";
}

}  // namespace

std::string zsh_completion(const CommandEntry& program) {
  std::string function = "_" + program.name;
  std::ostringstream out;
  out << "#compdef " << program.name << "\n# Completion in zsh. Made by " << program.name
      << " --print-completion zsh.\n\n"
      << function
      << "() {\n  local curcontext=$curcontext state line ret=1\n  local -A opt_args\n  _arguments -C -S \\\n";
  write_options(out, "    ", program.options);
  write_positionals(out, "    ", program.positionals);
  if (!program.subcommands.empty()) out << "    '1:command:->command' \\\n    '*::argument:->argument' \\\n";
  out << "    && ret=0\n";
  if (!program.subcommands.empty()) write_subcommands(out, program);
  out << "  return ret\n}\n\n" << function << " \"$@\"\n";
  return out.str();
}

}  // namespace vcd
