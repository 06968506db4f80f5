#include "option_table.h"

#include <algorithm>
#include <cctype>
#include <map>

#include <CLI/CLI.hpp>

#include <vcd/baker/ingest.h>

namespace vcd {
namespace {

// Help texts are broken into lines by hand.
std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

// What a check adds to the type name after a colon: "INT in [0 - 1024]", "POSITIVE".
std::string limits_of(std::string text) {
  const size_t from = text.find(" in ["), to = text.find(" - "), end = text.find(']');
  if (from < to && to < end && end != std::string::npos)
    return text.substr(from + 5, to - from - 5) + " to " + text.substr(to + 3, end - to - 3);
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

ValueEntry value_of(const CLI::Option& option) {
  static const std::map<std::string, Files> kKinds = {{"MESH", Files::meshes},
                                                      {"SIDECAR", Files::sidecars},
                                                      {"DIR", Files::folders},
                                                      {"FILE", Files::any},
                                                      {"PATH", Files::any}};
  ValueEntry value;
  const std::string type = option.get_type_name();
  const size_t colon = type.find(':');
  value.text = type.substr(0, colon);
  if (colon != std::string::npos) value.limits = limits_of(type.substr(colon + 1));
  if (value.text.ends_with("...")) value.text.resize(value.text.size() - 3);
  for (const std::string& part : CLI::detail::split(value.text, '|')) {
    const auto kind = kKinds.find(part);
    if (kind != kKinds.end()) value.files = kind->second;
    else if (!part.empty() && !std::isupper(static_cast<unsigned char>(part[0]))) value.words.push_back(part);
  }
  value.comma_list = option.get_delimiter() == ',';
  return value;
}

OptionEntry option_entry(const CLI::Option& option) {
  OptionEntry entry;
  if (option.get_positional()) entry.names.push_back(option.get_name(true));
  for (const std::string& name : option.get_snames()) entry.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) entry.names.push_back("--" + name);
  entry.description = one_line(option.get_description());
  entry.group = option.get_group();
  entry.takes_value = option.get_items_expected_max() > 0;
  if (entry.takes_value) entry.value = value_of(option);
  entry.required = option.get_required();
  entry.repeated = option.get_expected_max() == CLI::detail::expected_max_vector_size ||
                   option.get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
  return entry;
}

}  // namespace

CommandEntry option_table(const CLI::App& app) {
  CommandEntry command;
  command.name = app.get_name();
  command.description = one_line(app.get_description());
  command.footer = app.get_footer();
  for (const CLI::Option* option : app.get_options())
    if (!option->get_group().empty())
      (option->get_positional() ? command.positionals : command.options).push_back(option_entry(*option));
  for (const CLI::App* subcommand : app.get_subcommands([](const CLI::App*) { return true; }))
    if (!subcommand->get_group().empty()) command.subcommands.push_back(option_table(*subcommand));
  command.subcommands_take_options = app.get_fallthrough();
  return command;
}

std::vector<OptionEntry> options_after(const CommandEntry& program, const CommandEntry& subcommand) {
  std::vector<OptionEntry> options = subcommand.options;
  if (!program.subcommands_take_options) return options;
  for (const OptionEntry& option : program.options) {
    const bool taken = std::any_of(subcommand.options.begin(), subcommand.options.end(),
                                   [&](const OptionEntry& own) { return own.names == option.names; });
    if (!taken) options.push_back(option);
  }
  return options;
}

std::vector<std::string> extensions_of(Files files) {
  if (files == Files::meshes) return mesh_extensions();
  if (files == Files::sidecars) return {"vcd"};
  return {};
}

std::string joined(const std::vector<std::string>& words, const std::string& separator) {
  std::string out;
  for (const std::string& word : words) {
    if (&word != &words.front()) out += separator;
    out += word;
  }
  return out;
}

}  // namespace vcd
