#include <vcd/library/settings.h>

#include <gtest/gtest.h>

#include <fstream>

#include <vcd/library/provenance.h>

#include "support/files.h"

namespace vcd::library {
namespace {

// A text that changes the setting from its default.
std::string other_text(const Setting& setting) {
  if (setting.form == Setting::Form::flag) return "true";
  if (setting.form == Setting::Form::point) return "1,2.5,-3e10";
  if (setting.form == Setting::Form::file) return VCD_GOLDEN_DIR "/example.vcd";
  if (!setting.words.empty()) return std::string(setting.words[2 % setting.words.size()].text);
  return setting.most < 17 ? "5" : "17";
}

BakeSettings changed(const Setting& setting) {
  BakeSettings settings;
  const std::string text = other_text(setting) == "raw" ? "ship" : other_text(setting);
  EXPECT_FALSE(set(settings, setting.name, text)) << setting.name;
  return settings;
}

TEST(Settings, EachEntryChangesAMemberOfItsOwn) {
  const BakeSettings defaults;
  for (const Setting& setting : settings_table()) {
    EXPECT_NE(changed(setting), defaults) << setting.name;
    for (const Setting& other : settings_table()) {
      if (&other != &setting) {
        EXPECT_NE(changed(setting), changed(other)) << setting.name << " " << other.name;
      }
    }
  }
}

TEST(Settings, EachChangeMakesASidecarStale) {
  test::TemporaryFolder folder;
  const Asset before{folder.path() / "a.obj", folder.path() / "a.vcd", {}};
  for (const Setting& setting : settings_table()) {
    const Asset after{before.input, before.output, changed(setting)};
    const bool same = provenance_of(before, {}) == provenance_of(after, {});
    EXPECT_EQ(same, setting.scope == Scope::file) << setting.name;  // the file's storage shows in its sections
    EXPECT_NE(settings_text(before.settings, Scope::file), settings_text(after.settings, Scope::file)) << setting.name;
    EXPECT_EQ(settings_text(before.settings, Scope::object) == settings_text(after.settings, Scope::object),
              setting.scope != Scope::object)
        << setting.name;
  }
}

TEST(Settings, TheProvenanceOfABakeIsKnown) {
  EXPECT_EQ(
      settings_text({}, Scope::asset),
      R"({"depth":"auto","method":"hybrid","seed":0,"audit":1000000,"embed-geometry":false,"all-as-opaque":false})");
  BakeSettings settings{.depth = 5, .method = Method::sampled, .samples = 81, .budget_mb = 0.5, .budget_seconds = 3};
  EXPECT_EQ(settings_text(settings, Scope::file),
            R"({"depth":"5","method":"sampled","samples":81,"budget-mb":0.5,"budget-seconds":3.0,"seed":0,)"
            R"("audit":1000000,"storage":"raw","embed-geometry":false,"all-as-opaque":false})");
  settings = {.subdivide = 2, .shift = {1, 0.1, -3e10}, .allow_rounding = true, .allow_outside_files = true};
  EXPECT_EQ(
      settings_text(settings, Scope::asset),
      R"({"depth":"auto","method":"hybrid","seed":0,"audit":1000000,"embed-geometry":false,)"
      R"("all-as-opaque":false,"subdivide":2,"shift":"1,0.1,-3e+10","allow-rounding":true,"allow-outside-files":true})");
}

TEST(Settings, WhatIsNotTakenIsAnErrorAndChangesNothing) {
  BakeSettings settings;
  for (const auto& [name, text] : std::vector<std::pair<std::string, std::string>>{{"depth", "9"},
                                                                                   {"depth", ""},
                                                                                   {"method", "none"},
                                                                                   {"samples", "17"},
                                                                                   {"budget-mb", "nan"},
                                                                                   {"budget-mb", "0"},
                                                                                   {"budget-mb", "1x"},
                                                                                   {"seed", "-1"},
                                                                                   {"seed", "18446744073709551616"},
                                                                                   {"audit", "1e6"},
                                                                                   {"audit", "2000000001"},
                                                                                   {"embed-geometry", "1"},
                                                                                   {"subdivide", "7"},
                                                                                   {"shift", "1,2"},
                                                                                   {"shift", "1,2,3,4"},
                                                                                   {"shift", "1,2,inf"},
                                                                                   {"no-such", "1"}}) {
    const auto fault = set(settings, name, text);
    ASSERT_TRUE(fault) << name << " " << text;
    EXPECT_EQ(fault->code, ErrorCode::usage);
    EXPECT_TRUE(fault->message.starts_with(name + ": ")) << fault->message;
  }
  EXPECT_EQ(settings, BakeSettings());
}

}  // namespace
}  // namespace vcd::library
