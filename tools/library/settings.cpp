#include <vcd/library/settings.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>

#include <vcd/baker/source.h>

#include "common/describe.h"
#include "common/meshes.h"

namespace vcd::library {

using namespace baker;

namespace {

using namespace tools;

using Form = Setting::Form;
using Word = Setting::Word;
using Point = std::array<double, 3>;

constexpr uint64_t value_of(auto word) { return static_cast<uint64_t>(word); }

constexpr Word kDepths[] = {{"auto", 0}, {"1", 1}, {"2", 2}, {"3", 3}, {"4", 4},
                            {"5", 5},    {"6", 6}, {"7", 7}, {"8", 8}};
constexpr Word kDepthsElsewhere[] = {{"none", 0}, {"1", 1}, {"2", 2}, {"3", 3}, {"4", 4},
                                     {"5", 5},    {"6", 6}, {"7", 7}, {"8", 8}};
constexpr Word kMethods[] = {
    {"proven", value_of(Method::proven)}, {"hybrid", value_of(Method::hybrid)}, {"sampled", value_of(Method::sampled)}};
constexpr Word kSamples[] = {{"16", 16}, {"81", 81}, {"256", 256}};
constexpr Word kStorages[] = {{"raw", value_of(Storage::raw)}, {"ship", value_of(Storage::zstd)}};

constexpr Word kAxes[] = {{"none", 0}, {"x", 1}, {"y", 2}, {"z", 3}};

constexpr Setting kSettings[] = {
    {.name = "depth",
     .letter = 'd',
     .scope = Scope::object,
     .form = Form::word,
     .member = &BakeSettings::depth,
     .help = "Levels of the octree, 1 to 8. Each level costs five to twelve times more. auto: the deepest that pays "
             "(default)",
     .words = kDepths},
    {.name = "method",
     .letter = 'm',
     .scope = Scope::object,
     .form = Form::word,
     .member = &BakeSettings::method,
     .help = "proven: clear and blocked are proofs. hybrid: also cells that are blocked by statistics, kept apart from "
             "the proofs\n(default). sampled: statistics alone, as in the paper",
     .words = kMethods},
    {.name = "samples",
     .letter = 's',
     .scope = Scope::object,
     .form = Form::number,
     .member = &BakeSettings::samples,
     .help = "Sample rays a cell. --method sampled: 16, 81 or 256 (default: 256). --method hybrid, where a proof is "
             "missing: 81 or\n256 (default: 256; 81 where few cells are proven blocked, as in foliage)",
     .words = kSamples,
     .zero_is_none = true},
    {.name = "budget-mb",
     .letter = 0,
     .scope = Scope::object,
     .form = Form::number,
     .member = &BakeSettings::budget_mb,
     .help = "Most MiB that the sidecar of an object may take. First a lower depth is picked, then classes of cells "
             "are given up\n(default: 4 with --depth auto, else none)",
     .least = 0.02,
     .most = 1e6,
     .zero_is_none = true},
    {.name = "total-mb",
     .letter = 0,
     .scope = Scope::object,
     .form = Form::number,
     .member = &BakeSettings::total_mb,
     .help = "With --for, --for-lights or --for-above: most MiB that all assets of the run with this number may take "
             "together, shared out\nto their objects by what the demand gains (default: none)",
     .least = 0.02,
     .most = 1e6,
     .zero_is_none = true},
    {.name = "budget-seconds",
     .letter = 0,
     .scope = Scope::object,
     .form = Form::number,
     .member = &BakeSettings::budget_seconds,
     .help = "Most seconds that an object may take, from mesh to file. Cells without a class by then stay "
             "unclassified, so the\nresult depends on the machine (default: none)",
     .least = 0.1,
     .most = 1e9,
     .zero_is_none = true},
    {.name = "for",
     .letter = 0,
     .scope = Scope::object,
     .form = Form::file,
     .member = &BakeSettings::demand,
     .help = "Bake for this demand: deep where a scene's rays go, best first, until a budget ends it; as coarse as the "
             "top table\nwhere none go. Then --depth is the deepest level, auto by what\nis asked and the bytes. "
             "Without --budget-mb the tree takes 2 MiB at most, beside hierarchy and horizons",
     .zero_is_none = true},
    {.name = "for-lights",
     .letter = 0,
     .scope = Scope::object,
     .form = Form::flag,
     .member = &BakeSettings::for_lights,
     .help =
         "As --for, for shadow rays between the lights of a glTF scene, the ground below it and its surfaces, where "
         "its nodes\nplace them: no renderer is needed",
     .zero_is_none = true},
    {.name = "for-above",
     .letter = 0,
     .scope = Scope::object,
     .form = Form::word,
     .member = &BakeSettings::for_above,
     .help = "As --for, for shadow rays from the ground below each mesh to the whole sky; the axis that points up",
     .words = kAxes,
     .zero_is_none = true},
    {.name = "depth-elsewhere",
     .letter = 0,
     .scope = Scope::object,
     .form = Form::word,
     .member = &BakeSettings::depth_elsewhere,
     .help = "With --for, --for-lights or --for-above: how deep to divide first what the demand does not ask for "
             "(default: no deeper\nthan the top table)",
     .words = kDepthsElsewhere,
     .zero_is_none = true},
    {.name = "seed",
     .letter = 0,
     .scope = Scope::object,
     .form = Form::number,
     .member = &BakeSettings::seed,
     .help = "Seed of the sample rays (default: 0)",
     .most = 0x1p64},
    {.name = "audit",
     .letter = 0,
     .scope = Scope::object,
     .form = Form::number,
     .member = &BakeSettings::audit_lines,
     .help = "Fresh lines to check after each bake, a third of them aimed at the mesh; 0: none (default: 1000000)",
     .most = 2e9},
    {.name = "storage",
     .letter = 0,
     .scope = Scope::file,
     .form = Form::word,
     .member = &BakeSettings::storage,
     .help = "raw: renderers map the file as it is (default). ship: compressed",
     .words = kStorages},
    {.name = "no-hierarchy",
     .letter = 0,
     .scope = Scope::object,
     .form = Form::flag,
     .member = &BakeSettings::no_hierarchy,
     .help =
         "Leave out the hierarchy of boxes that answers what the cells leave unclassified, some 30 bytes a triangle",
     .zero_is_none = true},
    {.name = "horizons",
     .letter = 0,
     .scope = Scope::object,
     .form = Form::flag,
     .member = &BakeSettings::horizons,
     .help =
         "Store above which directions nothing stands, by triangle, for renderers that can name the triangle that a "
         "ray starts\non: 12 bytes a triangle; left out where it would answer less than a fifth of such rays",
     .zero_is_none = true},
    {.name = "embed-geometry",
     .letter = 0,
     .scope = Scope::object,
     .form = Form::flag,
     .member = &BakeSettings::embed_geometry,
     .help = "Store the welded triangles too, so that vc-verify needs no mesh file"},
    {.name = "all-as-opaque",
     .letter = 0,
     .scope = Scope::asset,
     .form = Form::flag,
     .member = &BakeSettings::all_as_opaque,
     .help = "Take parts that are alpha-masked, blended, transmissive, skinned or morphed too, as if they were opaque "
             "and rigid"},
    {.name = "subdivide",
     .letter = 0,
     .scope = Scope::asset,
     .form = Form::number,
     .member = &BakeSettings::subdivide,
     .help =
         "Subdivide each mesh so many times by Loop's scheme; each time a triangle becomes four. For control meshes "
         "of\nsubdivision surfaces; vc-scene writes the same triangles for a renderer (default: 0)",
     .most = kMostSubdivisions,
     .zero_is_none = true},
    {.name = "shift",
     .letter = 0,
     .scope = Scope::asset,
     .form = Form::point,
     .member = &BakeSettings::shift,
     .help = "Subtract x,y,z from all coordinates before they are rounded to 32-bit floats. For meshes far from their "
             "origin; the\nsidecar records it (default: 0,0,0)",
     .zero_is_none = true},
    {.name = "allow-rounding",
     .letter = 0,
     .scope = Scope::asset,
     .form = Form::flag,
     .member = &BakeSettings::allow_rounding,
     .help =
         "Take a mesh even if rounding to 32-bit floats moves its coordinates by more than a thousandth of its size",
     .zero_is_none = true},
    {.name = "allow-outside-files",
     .letter = 0,
     .scope = Scope::asset,
     .form = Form::flag,
     .member = &BakeSettings::allow_outside_files,
     .help = "Let a mesh file name files that are not in its folder or below it; for trusted files only",
     .zero_is_none = true},
};

// Of an aggregate: how many values its braces take.
struct Anything {
  template <class T>
  operator T() const;
};
template <class Aggregate, class... Values>
consteval size_t member_count() {
  if constexpr (requires { Aggregate{Values{}..., Anything{}}; }) return member_count<Aggregate, Values..., Anything>();
  else return sizeof...(Values);
}
static_assert(member_count<BakeSettings>() == std::size(kSettings),
              "a setting without an entry would leave sidecars up to date that are not");

bool parse(std::string_view text, double& value) {
  const std::string copy(text);
  char* end = nullptr;
  value = std::strtod(copy.c_str(), &end);
  return !copy.empty() && end == copy.c_str() + copy.size();
}

bool parse(std::string_view text, uint64_t& value) {
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  return fault == std::errc() && end == text.data() + text.size();
}

// False if the setting does not take this text.
template <class T>
bool take(const Setting& setting, std::string_view text, T& value) {
  if constexpr (std::is_same_v<T, bool>) {
    if (text != "true" && text != "false") return false;
    value = text == "true";
  } else if constexpr (std::is_same_v<T, DemandFile>) {
    const auto hash = hash_file(text);
    if (!hash) return false;
    value = {text, hex(*hash)};
  } else if constexpr (std::is_same_v<T, Point>) {
    const auto point = parse_shift(text);
    if (!point) return false;
    value = *point;
  } else if (!setting.words.empty()) {
    const auto word = std::ranges::find(setting.words, text, &Word::text);
    if (word == setting.words.end()) return false;
    value = static_cast<T>(word->value);
  } else {
    std::conditional_t<std::is_same_v<T, double>, double, uint64_t> number;
    if (!parse(text, number)) return false;
    const auto size = static_cast<double>(number);
    if (!(size >= setting.least && size <= setting.most)) return false;  // NaN is neither
    value = static_cast<T>(number);
  }
  return true;
}

bool is_zero(auto value) { return !(static_cast<double>(value) > 0); }
bool is_zero(const Point& value) { return value == Point{}; }
bool is_zero(const DemandFile& value) { return value.path.empty(); }

Json json_of(const Setting&, const Point& value) { return shift_text(value); }
Json json_of(const Setting&, const DemandFile& value) { return value.hash; }

template <class T>
Json json_of(const Setting& setting, T value) {
  if (setting.form != Form::word) {
    if constexpr (std::is_enum_v<T>) return value_of(value);
    else return value;
  }
  const auto word = std::ranges::find(setting.words, value_of(value), &Word::value);
  return word == setting.words.end() ? Json(nullptr) : Json(word->text);
}

// " in [0.1 - 1000000]"; empty for any number.
std::string range_of(const Setting& setting) {
  char range[64] = "";
  if (setting.most < 0x1p64) std::snprintf(range, sizeof range, " in [%.10g - %.10g]", setting.least, setting.most);
  return range;
}

}  // namespace

BakeOptions BakeSettings::bake_options() const {
  BakeOptions options;
  options.depth = depth;
  options.method = method;
  options.samples = samples;
  options.budget_bytes = static_cast<uint64_t>(budget_mb * 1048576);
  options.budget_seconds = budget_seconds;
  options.depth_elsewhere = for_a_demand() ? depth_elsewhere : 0;
  options.seed = seed;
  options.hierarchy = !no_hierarchy;
  options.horizons = horizons;
  options.embed_geometry = embed_geometry;
  options.audit_lines = audit_lines;
  return options;
}

IngestOptions BakeSettings::ingest_options() const {
  return {.treat_all_as_opaque = all_as_opaque,
          .lights = for_lights,
          .files_outside = allow_outside_files,
          .shift = shift,
          .coarse = allow_rounding,
          .subdivide = subdivide};
}

std::span<const Setting> settings_table() { return kSettings; }

std::string values_of(const Setting& setting) {
  std::string text;
  for (const Word& word : setting.words) text += (text.empty() ? "" : "|") + std::string(word.text);
  if (!text.empty()) return text;
  if (setting.form == Form::point) return "X,Y,Z";
  if (setting.form == Form::file) return "FILE";
  return setting.form == Form::flag ? "true|false" : "NUMBER" + range_of(setting);
}

std::optional<Error> set(BakeSettings& settings, std::string_view name, std::string_view text) {
  const auto setting = std::ranges::find(kSettings, name, &Setting::name);
  if (setting == std::end(kSettings)) return Error{ErrorCode::usage, std::string(name) + ": there is no such setting"};
  const bool is_taken =
      std::visit([&](auto member) { return take(*setting, text, settings.*member); }, setting->member);
  if (is_taken) return std::nullopt;
  const bool is_number = setting->words.empty() && setting->form == Form::number;
  const std::string wanted = is_number                      ? "a number" + range_of(*setting)
                             : setting->form == Form::point ? "three numbers x,y,z"
                             : setting->form == Form::file  ? "a file that can be read"
                                                            : values_of(*setting);
  return Error{ErrorCode::usage, std::string(name) + ": " + std::string(text) + " is not " + wanted};
}

std::string settings_text(const BakeSettings& settings, Scope scope) {
  Json json = Json::object();
  for (const Setting& setting : kSettings) {
    if (setting.scope > scope) continue;
    std::visit(
        [&](auto member) {
          const auto value = settings.*member;
          if (setting.zero_is_none && is_zero(value)) return;
          json[std::string(setting.name)] = json_of(setting, value);
        },
        setting.member);
  }
  return json.dump();
}

}  // namespace vcd::library
