// A program's options as data: what its man page and its completions are made from.
//
// A type name says what a value is, and is the only place that does: alternatives parted by "|". One in capitals is a
// kind of value, any other a word to type as it stands: "raw|ship", "auto|1|2", "sierpinski|hairball|MESH". Kinds that
// are files: MESH, SIDECAR, DIR, and FILE and PATH for any. A check that would add its own list of words gets
// description("").
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace vcd {

enum class Files { none, meshes, sidecars, folders, any };

struct ValueEntry {
  std::string text;                // as in the help: "PATH", "raw|ship", without "..."
  std::vector<std::string> words;  // to choose from
  Files files = Files::none;
  std::string limits;       // "0 to 1024", "positive" or empty
  bool comma_list = false;  // several with commas
};

struct OptionEntry {
  std::vector<std::string> names;  // "-o", "--output"; one without dashes if positional
  std::string description;         // one line
  std::string group;
  bool takes_value = false;
  ValueEntry value;
  bool required = false;
  bool repeated = false;
};

struct CommandEntry {
  std::string name;
  std::string description;  // one line
  std::vector<OptionEntry> options, positionals;
  std::vector<CommandEntry> subcommands;
  bool subcommands_take_options = false;  // those of the program, too
  std::string footer;                     // with its lines
};

// Options of the empty group are hidden, here as in the help.
CommandEntry option_table(const CLI::App& app);

// What may follow a subcommand: its own options, and those of the program if they fall through.
std::vector<OptionEntry> options_after(const CommandEntry& program, const CommandEntry& subcommand);

// "glb", "gltf", …; "vcd"; empty for others.
std::vector<std::string> extensions_of(Files files);

std::string joined(const std::vector<std::string>& words, const std::string& separator = " ");

}  // namespace vcd
