// What one asset is baked with: the settings that decide about the bytes of its sidecar, each described once.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include <vcd/baker/bake.h>
#include <vcd/baker/ingest.h>

namespace vcd::library {

// A demand that a bake is for. Its content counts, not its name.
struct DemandFile {
  std::filesystem::path path;  // empty: none
  std::string hash;            // of the content when the setting was set, hexadecimal

  bool operator==(const DemandFile&) const = default;
};

// Each member has an entry in settings_table(): a forgotten one does not compile.
struct BakeSettings {
  uint32_t depth = 0;  // 1 to 8; 0: the deepest that pays
  Method method = Method::hybrid;
  uint32_t samples = 0;       // 0: the method's own number
  double budget_mb = 0;       // MiB; 0: none
  double total_mb = 0;        // MiB of all assets of a run with this number, for a demand; 0: none
  double budget_seconds = 0;  // 0: none
  DemandFile demand = {};
  bool for_lights = false;       // for a demand of the scene file's lights
  uint32_t for_above = 0;        // for a demand of the sky; 1 to 3: the axis x, y or z points up
  uint32_t depth_elsewhere = 0;  // for a demand: to which depth all is divided that it does not ask for; 0: not
  uint64_t seed = 0;
  uint64_t audit_lines = 1000000;
  Storage storage = Storage::raw;
  bool no_hierarchy = false;
  bool horizons = false;
  bool embed_geometry = false;
  bool all_as_opaque = false;
  uint32_t subdivide = 0;            // times, by Loop's scheme
  std::array<double, 3> shift = {};  // subtracted from all coordinates
  bool allow_rounding = false;
  bool allow_outside_files = false;

  bool operator==(const BakeSettings&) const = default;

  // Threads, progress and stop are the caller's, and so is the demand: read_demand() of its file.
  bool for_a_demand() const { return for_lights || for_above > 0 || !demand.path.empty(); }
  baker::BakeOptions bake_options() const;
  baker::IngestOptions ingest_options() const;
};

// What a setting decides: the content of each object; which triangles the asset's objects have, too; how the file
// stores its content.
enum class Scope : uint8_t { object, asset, file };

// One setting: an option of the programs, a member of a manifest, a member of the sidecar's provenance.
struct Setting {
  // As JSON: true or false, a number, a text, a text "x,y,z", a path.
  enum class Form : uint8_t { flag, number, word, point, file };
  struct Word {
    std::string_view text;
    uint64_t value;
  };
  using Member = std::variant<bool BakeSettings::*, uint32_t BakeSettings::*, uint64_t BakeSettings::*,
                              double BakeSettings::*, Method BakeSettings::*, Storage BakeSettings::*,
                              std::array<double, 3> BakeSettings::*, DemandFile BakeSettings::*>;

  std::string_view name;  // "budget-mb": --budget-mb, "budget-mb": …
  char letter;            // of the option; 0: none
  Scope scope;
  Form form;
  Member member;
  std::string_view help;
  std::span<const Word> words = {};  // what it takes; empty: a number from `least` to `most`
  double least = 0, most = 0;
  bool zero_is_none = false;  // then zero, or false, is not written
};
std::span<const Setting> settings_table();

// What the setting takes, for a help text: "raw|ship", "NUMBER in [0.1 - 1000000000]".
std::string values_of(const Setting& setting);

// Sets the setting of that name from its text: a word, a number, true or false. An error (usage) names the setting and
// says what it takes; then `settings` is unchanged.
std::optional<Error> set(BakeSettings& settings, std::string_view name, std::string_view text);

// The settings of this scope and below as a JSON object, the same text for the same settings. A demand is its hash.
std::string settings_text(const BakeSettings& settings, Scope scope);

}  // namespace vcd::library
