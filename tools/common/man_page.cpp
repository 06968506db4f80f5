#include "man_page.h"

#include <algorithm>
#include <cctype>
#include <sstream>

namespace vcd {
namespace {

// Text as troff shows it unchanged, and as it can be copied from a page: a bare hyphen would come out as a dash, a dot
// that begins a line would be a request.
std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '.' && (out.empty() || out.back() == '\n')) out += "\\&";
    if (c == '\\') out += "\\(rs";
    else if (c == '-') out += "\\-";
    else if (c == '\'') out += "\\(aq";
    else if (c == '`') out += "\\(ga";
    else if (c == '^') out += "\\(ha";
    else if (c == '~') out += "\\(ti";
    else out += c;
  }
  return out;
}

std::string bold(const std::string& text) { return "\\fB" + escaped(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + escaped(text) + "\\fR"; }

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

// What is typed as it stands is bold, what stands for something else italic.
std::string shown_value(const ValueEntry& value) {
  std::vector<std::string> shown;
  std::istringstream parts(value.text);
  for (std::string part; std::getline(parts, part, '|');) {
    const bool is_word = std::find(value.words.begin(), value.words.end(), part) != value.words.end();
    shown.push_back(is_word ? bold(part) : italic(part));
  }
  return joined(shown, "|").append(value.comma_list ? "[,...]" : "");
}

std::string heading(const OptionEntry& option, bool positional) {
  if (positional) return shown_value(option.value).append(option.repeated ? "..." : "");
  std::vector<std::string> names;
  for (const std::string& name : option.names) names.push_back(bold(name));
  const std::string shown = joined(names, ", ");
  return option.takes_value ? joined({shown, shown_value(option.value)}) : shown;
}

void write_entry(std::ostream& out, const OptionEntry& option, bool positional) {
  out << ".TP\n" << heading(option, positional) << '\n';
  out << escaped(option.description.empty() ? option.names[0] : option.description) << '\n';
  if (!option.value.limits.empty()) out << ".br\nAccepted: " << escaped(option.value.limits) << ".\n";
}

void write_options(std::ostream& out, const std::vector<OptionEntry>& options) {
  std::vector<std::string> groups;
  for (const OptionEntry& option : options)
    if (std::find(groups.begin(), groups.end(), option.group) == groups.end()) groups.push_back(option.group);
  for (const std::string& group : groups) {
    if (group != "Options") out << ".SS \"" << escaped(group) << "\"\n";
    for (const OptionEntry& option : options)
      if (option.group == group) write_entry(out, option, false);
  }
}

void write_synopsis(std::ostream& out, const std::string& program, const CommandEntry& command) {
  out << bold(program);
  if (command.name != program) out << ' ' << bold(command.name);
  out << " [" << italic("OPTIONS") << ']';
  for (const OptionEntry& option : command.options)
    if (option.required) out << ' ' << bold(option.names[0]) << ' ' << shown_value(option.value);
  for (const OptionEntry& positional : command.positionals) {
    const std::string shown = heading(positional, true);
    out << ' ' << (positional.required ? shown : "[" + shown + "]");
  }
  out << '\n';
}

void write_subcommand(std::ostream& out, const CommandEntry& command) {
  out << ".SS \"" << escaped(command.name) << "\"\n" << escaped(command.description) << ".\n";
  for (const OptionEntry& positional : command.positionals) write_entry(out, positional, true);
  for (const OptionEntry& option : command.options) write_entry(out, option, false);
}

// Paragraphs of the footer, "Title:" and lines that stand as they are.
void write_footer(std::ostream& out, const std::string& footer) {
  std::istringstream lines(footer);
  bool literal = false;
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty() && line[0] != ' ' && line.back() == ':') {
      if (literal) out << ".fi\n";
      out << ".SH \"" << escaped(upper(line.substr(0, line.size() - 1))) << "\"\n.nf\n";
      literal = true;
    } else if (!line.empty()) {
      out << escaped(line) << '\n';
    }
  }
  if (literal) out << ".fi\n";
}

// "Bakes sidecars: for each mesh …" -> "bakes sidecars".
std::string summary(const std::string& description) {
  std::string out =
      description.substr(0, std::min({description.find(": "), description.find(". "), description.size()}));
  if (out.ends_with('.')) out.pop_back();
  if (!out.empty()) out[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(out[0])));
  return out;
}

}  // namespace

std::string man_page(const CommandEntry& program) {
  std::ostringstream out;
  out << ".\\\" Made by " << program.name << " --print-man.\n"
      << ".TH " << escaped(upper(program.name)) << " 1 \"\" \"vcd " VCD_VERSION "\" \"vcd\"\n"
      << ".SH NAME\n"
      << escaped(program.name) << " \\- " << escaped(summary(program.description)) << '\n'
      << ".SH SYNOPSIS\n";
  write_synopsis(out, program.name, program);
  for (const CommandEntry& command : program.subcommands) {
    out << ".br\n";
    write_synopsis(out, program.name, command);
  }
  out << ".SH DESCRIPTION\n" << escaped(program.description) << '\n';
  for (const OptionEntry& positional : program.positionals) write_entry(out, positional, true);
  out << ".SH OPTIONS\n";
  write_options(out, program.options);
  if (!program.subcommands.empty()) out << ".SH COMMANDS\n";
  if (program.subcommands_take_options && !program.subcommands.empty())
    out << "The options above may follow a command too.\n";
  for (const CommandEntry& command : program.subcommands) write_subcommand(out, command);
  write_footer(out, program.footer);
  return out.str();
}

}  // namespace vcd
