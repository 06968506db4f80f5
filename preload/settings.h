// What the environment asks for; see spec/preload.md.
#pragma once

#include <filesystem>
#include <vector>

namespace vcd::preload {

enum class Answers {
  proven,       // look-ups of proofs: equal to Embree wherever Embree is right
  statistical,  // look-ups of statistics too
  exact,        // proofs, and what they leave unclassified the sidecars' hierarchies decide
  none,         // everything is left to Embree: for counting, and for VCD_EXPORT
};

struct Settings {
  std::vector<std::filesystem::path> sidecars;  // VCD_SIDECARS=FOLDER[:FOLDER ...]
  std::filesystem::path export_to;              // VCD_EXPORT=FOLDER; empty: meshes are not exported
  Answers answers = Answers::proven;            // VCD_ANSWERS=proven|statistical|exact|none
  bool look_up_always = false;                  // VCD_LOOK_UP=measured|always: whether or not it saves time

  bool reads_meshes() const { return !export_to.empty() || (answers != Answers::none && !sidecars.empty()); }
};

// Read once. Ends the program with a message where a variable makes no sense. Safe from any thread.
const Settings& settings();

}  // namespace vcd::preload
