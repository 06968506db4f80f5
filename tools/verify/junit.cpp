#include <sstream>

#include <pugixml.hpp>

#include "common/exit_codes.h"
#include "common/paths.h"
#include "reports.h"

namespace vcd::verify {

using namespace tools;
namespace {

// XML 1.0 cannot hold U+FFFE and U+FFFF, however they are written, nor control characters; those `shown` has taken out.
std::string xml_text(const std::string& text) {
  std::string clean = text;
  for (const auto& [code, words] : {std::pair("\xEF\xBF\xBE", "\\ufffe"), std::pair("\xEF\xBF\xBF", "\\uffff")})
    for (size_t at = 0; (at = clean.find(code, at)) != std::string::npos;) clean.replace(at, 3, words);
  return clean;
}

void set(pugi::xml_node node, const char* attribute, const std::string& text) {
  node.append_attribute(attribute) = xml_text(text).c_str();
}

struct Words {
  std::string errors, warnings, first_error, first_id;
};

Words words_of(const Outcome& outcome) {
  Words words;
  for (const Issue& issue : outcome.issues) {
    const bool is_error = issue.severity == Severity::error;
    (is_error ? words.errors : words.warnings) += issue.text() + "\n";
    if (is_error && words.first_error.empty()) words.first_error = issue.text(), words.first_id = issue.info->id;
  }
  return words;
}

// Nothing was found out about it: it could not be read, or not all of it was asked.
bool could_not_be_run(const Outcome& outcome) {
  for (const ErrorCode code : {ErrorCode::io, ErrorCode::runtime, ErrorCode::usage})
    if (outcome.exit_code() == exit_code(code)) return true;
  return false;
}

struct Suite {
  pugi::xml_node node;
  unsigned long long tests = 0, failures = 0, errors = 0, skipped = 0;

  void add(const Outcome& outcome) {
    constexpr const char* kClasses[] = {"inputs", "sidecars", "assets"};
    const std::string name = shown(outcome.path);
    const Words words = words_of(outcome);
    pugi::xml_node test = node.append_child("testcase");
    set(test, "classname", kClasses[static_cast<size_t>(outcome.subject)]);
    set(test, "name", name);
    set(test, "file", name);
    ++tests;
    if (outcome.failed()) {
      const bool is_error = could_not_be_run(outcome);
      ++(is_error ? errors : failures);
      pugi::xml_node fault = test.append_child(is_error ? "error" : "failure");
      set(fault, "type", words.first_id);
      set(fault, "message", words.first_error);
      fault.text() = xml_text(words.errors).c_str();
    } else if (outcome.subject == Subject::asset) {
      ++skipped;
      set(test.append_child("skipped"), "message", words.warnings.substr(0, words.warnings.find('\n')));
    }
    if (!words.warnings.empty()) test.append_child("system-out").text() = xml_text(words.warnings).c_str();
  }

  void finish(const Totals& totals) {
    node.append_attribute("tests") = tests, node.append_attribute("failures") = failures;
    node.append_attribute("errors") = errors, node.append_attribute("skipped") = skipped;
    pugi::xml_node properties = node.prepend_child("properties");
    const Json counts = describe_totals(totals);
    for (const auto& [key, value] : counts.items()) {
      pugi::xml_node property = properties.append_child("property");
      set(property, "name", key);
      set(property, "value", value.dump());
    }
  }
};

}  // namespace

std::string junit(const Run& run) {
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  set(declaration, "version", "1.0");
  set(declaration, "encoding", "UTF-8");
  Suite suite{document.append_child("testsuites").append_child("testsuite")};
  set(suite.node, "name", "vc-verify");
  for (const Outcome& outcome : run.outcomes)
    if (outcome.subject != Subject::asset || !outcome.issues.empty()) suite.add(outcome);
  suite.finish(run.totals);
  std::ostringstream out;
  document.save(out, " ");
  return out.str();
}

}  // namespace vcd::verify
