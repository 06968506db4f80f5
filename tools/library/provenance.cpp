#include <vcd/library/provenance.h>

#include <algorithm>
#include <cstdio>
#include <optional>

#include <vcd/baker/bake.h>

#include "common/paths.h"

namespace vcd::library {

using namespace baker;
namespace {

using namespace tools;

// Printable ASCII but for %, so that any name keeps to one line of UTF-8.
std::string escaped(const std::string& name) {
  std::string text;
  for (const char c : name) {
    char code[4];
    std::snprintf(code, sizeof code, "%%%02X", static_cast<unsigned char>(c));
    text += c <= ' ' || c == '%' || c > '~' ? std::string(code) : std::string(1, c);
  }
  return text;
}

std::optional<std::string> unescaped(std::string_view text) {
  std::string name;
  for (size_t i = 0; i < text.size(); ++i) {
    unsigned byte = static_cast<unsigned char>(text[i]);
    if (text[i] == '%') {
      if (std::sscanf(std::string(text.substr(i + 1, 2)).c_str(), "%2x", &byte) != 1) return std::nullopt;
      i += 2;
    }
    name += static_cast<char>(byte);
  }
  return name;
}

std::optional<ContentHash> parse_hash(std::string_view digits) {
  ContentHash hash{};
  if (digits.size() != 2 * hash.size()) return std::nullopt;
  for (size_t i = 0; i < hash.size(); ++i) {
    unsigned byte = 0;
    if (std::sscanf(std::string(digits.substr(2 * i, 2)).c_str(), "%2x", &byte) != 1) return std::nullopt;
    hash[i] = static_cast<uint8_t>(byte);
  }
  return hash;
}

}  // namespace

std::string baker_text() { return "vc-bake revision " + std::to_string(kBakeRevision); }

std::string_view provenance_value(const SidecarContents& sidecar, std::string_view key) {
  for (const auto& [k, value] : sidecar.provenance)
    if (k == key) return value;
  return {};
}

std::map<std::string, std::string> provenance_of(const Asset& asset, const std::vector<SourceFile>& sources,
                                                 const std::string& left_out, const std::string& demand) {
  std::map<std::string, std::string> pairs = {{"baker", baker_text()},
                                              {"parts", asset.settings.all_as_opaque ? "all, as opaque" : "opaque"},
                                              {"settings", settings_text(asset.settings, Scope::asset)},
                                              {"source", shown(asset.input.filename())}};
  if (asset.settings.subdivide > 0) pairs["subdivide"] = std::to_string(asset.settings.subdivide);
  if (!left_out.empty()) pairs["left-out"] = left_out;
  if (!demand.empty()) pairs["demand"] = demand;
  if (!sources.empty()) pairs["source-xxh3"] = hex(sources[0].hash);
  for (size_t i = 1; i < sources.size(); ++i)
    pairs["dependencies"] += hex(sources[i].hash) + " " + escaped(sources[i].name) + "\n";
  return pairs;
}

std::string demand_line(uint32_t source_index, const DemandReport& report) {
  char line[128];
  std::snprintf(line, sizeof line, "%u kept-out=%llu answered=%.6f wrong=%llu\n", source_index,
                static_cast<unsigned long long>(report.segments), report.share(),
                static_cast<unsigned long long>(report.wrong));
  return line;
}

std::vector<SourceFile> dependencies_of(const SidecarContents& sidecar) {
  std::vector<SourceFile> files;
  std::string_view rest = provenance_value(sidecar, "dependencies");
  while (!rest.empty()) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(rest.size(), line.size() + 1));
    const size_t space = std::min(line.find(' '), line.size());
    const auto hash = parse_hash(line.substr(0, space));
    const auto name = unescaped(line.substr(std::min(line.size(), space + 1)));
    files.push_back({name.value_or(""), hash.value_or(ContentHash{})});  // of what makes no sense nothing will match
  }
  return files;
}

}  // namespace vcd::library
