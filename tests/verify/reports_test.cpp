#include "verify/reports.h"

#include <gtest/gtest.h>

#include <set>

#include <pugixml.hpp>

#include "common/uri.h"

namespace vcd::verify {
namespace {

std::string from_percent(const std::string& uri) {
  std::string bytes;
  for (size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] != '%') bytes += uri[i];
    else bytes += static_cast<char>(std::stoi(uri.substr(i + 1, 2), nullptr, 16)), i += 2;
  }
  return bytes;
}

TEST(Uri, GivesEveryByteBack) {
  std::string name = "a/b";
  for (int byte = 1; byte < 256; ++byte) name += static_cast<char>(byte);
  const std::string uri = tools::uri_of(name);
  EXPECT_EQ(from_percent(uri), name);
  for (const char c : uri)
    EXPECT_TRUE(std::isalnum(static_cast<unsigned char>(c)) ||
                std::string_view("-._~/%").find(c) != std::string_view::npos)
        << c;
}

TEST(Uri, RelativeAndAbsolute) {
  EXPECT_EQ(tools::uri_of("a:b/c d.vcd"), "a%3Ab/c%20d.vcd");  // unescaped, "a" would be a scheme
  EXPECT_EQ(tools::uri_of("/x/\xff.vcd"), "file:///x/%FF.vcd");
}

TEST(Findings, IdsAreUnique) {
  std::set<std::string> ids;
  for (const FindingInfo* info : every_finding()) EXPECT_TRUE(ids.insert(info->id).second) << info->id;
  EXPECT_GT(ids.size(), all_findings().size());
}

Run run_of(std::vector<Outcome> outcomes) {
  Run run{std::move(outcomes), {}};
  for (const Outcome& outcome : run.outcomes) run.totals.add(outcome);
  return run;
}

TEST(Junit, HoldsNoCharacterThatXmlForbids) {
  Outcome outcome{.path = "a\x01\n<&>\"'\xff.vcd"}, utf8{.path = "\xEF\xBF\xBF\xEF\xBF\xBE.vcd"};
  outcome.add(IssueId::stale, ErrorCode::stale, "object \x02", "]]> \x1b and \xEF\xBF\xBF");
  const std::string xml = junit(run_of({outcome, utf8}));
  for (const char c : xml) EXPECT_TRUE(static_cast<unsigned char>(c) >= 32 || c == '\n') << int{c};
  for (const char* forbidden : {"\xEF\xBF\xBF", "\xEF\xBF\xBE", "&#1;", "&#27;", "\xff"})
    EXPECT_EQ(xml.find(forbidden), std::string::npos);
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(xml.c_str()));
  const auto test = document.child("testsuites").child("testsuite").child("testcase");
  EXPECT_STREQ(test.attribute("name").value(), "a\\x01\\x0a<&>\"'\\xff.vcd");
  EXPECT_STREQ(test.child("failure").attribute("type").value(), "stale");
}

TEST(Totals, EachSidecarIsOneOfThree) {
  Outcome ok{.path = "ok"}, failed{.path = "failed"}, not_verified{.path = "not"}, warned{.path = "warned"};
  failed.add(IssueId::orphaned, ErrorCode::difference, "object 0", "");
  failed.add(IssueId::orphaned, ErrorCode::difference, "object 1", "");
  not_verified.add(IssueId::not_verified, ErrorCode::runtime, "", "");
  warned.add(IssueId::misnamed, ErrorCode::difference, "", "");
  const auto run = run_of({ok, failed, not_verified, warned});
  EXPECT_EQ(run.totals.sidecars, 4u);
  EXPECT_EQ(run.totals.ok, 2u);
  EXPECT_EQ(run.totals.failed, 1u);
  EXPECT_EQ(run.totals.not_verified, 1u);
  EXPECT_EQ(run.totals.warnings, 1u);
  EXPECT_EQ(run.totals.failed_by_finding,
            (std::map<std::string, uint64_t>{{"not-verified", 1}, {"orphaned", 1}}));  // files, not findings
}

TEST(ExitCode, IsThatOfTheOnlyInputElseNine) {
  Outcome ok{.path = "ok"}, stale{.path = "stale"}, asset{.subject = Subject::asset, .path = "asset"}, missing = asset;
  stale.add(IssueId::stale, ErrorCode::stale, "", "");
  missing.add(IssueId::missing, ErrorCode::difference, "", "");
  EXPECT_EQ(run_of({ok}).exit_code(), 0);
  EXPECT_EQ(run_of({stale, asset}).exit_code(), 8);
  EXPECT_EQ(run_of({ok, stale}).exit_code(), 9);
  EXPECT_EQ(run_of({ok, missing}).exit_code(), 9);
  missing.issues[0].severity = Severity::warning;
  EXPECT_EQ(run_of({ok, missing}).exit_code(), 0);
}

}  // namespace
}  // namespace vcd::verify
