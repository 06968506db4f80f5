#include "completions.h"

#include <algorithm>
#include <sstream>

namespace vcd {
namespace {

// The same for every program: walks a table, one row an option or a positional argument.
constexpr const char* kEngine = R"bash(
# ROW...: COMMAND|NAMES or place of a positional argument, + for all from here on|VALUES, empty for a flag.
# Values: words; *.EXTENSION and *: files; /: folders; a comma: several with commas; -: nothing to choose from.
_vcd_complete() {
  local cur=${COMP_WORDS[COMP_CWORD]} command='' values='' place=1 i word
  COMPREPLY=()
  [[ $cur == '=' ]] && cur=''  # --option=VALUE comes as three words, @FILE as two
  [[ ${COMP_WORDS[COMP_CWORD - 1]} == '@' ]] && cur=@$cur
  if [[ $cur == @* ]]; then
    mapfile -t COMPREPLY < <(compgen -P @ -f -- "${cur#@}")
    return
  fi
  for ((i = 1; i < COMP_CWORD; ++i)); do
    word=${COMP_WORDS[i]}
    if [[ $word == [=@] ]]; then
      continue
    elif [[ -n $values ]]; then
      values=''
    elif [[ $word == -* ]]; then
      values=$(_vcd_values "$command" "$word" "$@")
    elif [[ -z $command && " $*" == *" $word|"* ]]; then
      command=$word place=1
    else
      ((++place))
    fi
  done
  if [[ -z $values && $cur == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(_vcd_names "$command" "$@")" -- "$cur")
    return
  fi
  local -a choices
  [[ -n $values ]] || values=$(_vcd_values "$command" "$place" "$@")
  [[ -n $values ]] || values=$(_vcd_values "$command" + "$@")
  read -ra choices <<< "$values"
  mapfile -t COMPREPLY < <(_vcd_choose "${choices[@]}")
  [[ $values == *[*/]* ]] && compopt -o filenames 2> /dev/null
  [[ $values == ,* ]] && compopt -o nospace 2> /dev/null
}

_vcd_values() {  # COMMAND NAME ROW...
  local command=$1 name=$2 row names
  shift 2
  for row; do
    names=${row#*|} names=,${names%%|*},
    [[ ${row%%|*} == "$command" && $names == *",$name,"* ]] && printf '%s' "${row##*|}" && return
  done
}

_vcd_names() {  # COMMAND ROW...
  local command=$1 row names
  shift
  for row; do
    names=${row#*|} names=${names%%|*}
    [[ ${row%%|*} == "$command" && $names == -* ]] && printf '%s ' "${names//,/ }"
  done
}

_vcd_choose() {  # VALUE...
  local value before=''
  shopt -s nocasematch
  for value; do
    case $value in
      -) ;;
      ,) before=${cur%"${cur##*,}"} ;;
      /) compgen -d -- "$cur" ;;
      '*') compgen -f -- "$cur" ;;
      '*.'*) compgen -f -X "!$value" -- "$cur" ;;
      *) compgen -P "$before" -W "$value" -- "${cur#"$before"}" ;;
    esac
  done
}
)bash";

std::string values_of(const ValueEntry& value) {
  std::vector<std::string> out = value.words;
  if (value.comma_list) out.insert(out.begin(), ",");
  if (value.files == Files::any) out.push_back("*");
  else if (value.files != Files::none) out.push_back("/");
  for (const std::string& extension : extensions_of(value.files)) out.push_back("*." + extension);
  return out.empty() ? "-" : joined(out);
}

std::string row(const std::string& command, const std::string& names, const std::string& values) {
  return "    '" + command + '|' + names + '|' + values + "'\n";
}

std::string rows(const std::string& command, const std::vector<OptionEntry>& options,
                 const std::vector<OptionEntry>& positionals) {
  std::string out;
  for (const OptionEntry& option : options) {
    out += row(command, joined(option.names, ","), option.takes_value ? values_of(option.value) : "");
  }
  int place = 0;
  for (const OptionEntry& positional : positionals) {
    ++place;
    out += row(command, positional.repeated ? "+" : std::to_string(place), values_of(positional.value));
  }
  return out;
}

}  // namespace

std::string bash_completion(const CommandEntry& program) {
  std::string function = "_" + program.name;
  std::replace(function.begin(), function.end(), '-', '_');
  std::ostringstream out;
  out << "# Completion of " << program.name << " in bash. Made by " << program.name << " --print-completion bash.\n"
      << kEngine << '\n'
      << function << "() {\n  local -a rows=(\n"
      << rows("", program.options, program.positionals);
  std::vector<std::string> names;
  for (const CommandEntry& command : program.subcommands) {
    names.push_back(command.name);
    out << rows(command.name, options_after(program, command), command.positionals);
  }
  if (!names.empty()) out << row("", "1", joined(names));
  out << "  )\n  _vcd_complete \"${rows[@]}\"\n}\ncomplete -F " << function << ' ' << program.name << '\n';
  return out.str();
}

}  // namespace vcd
