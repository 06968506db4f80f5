// Sidecar contents as text and JSON: the same words in every program.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include <vcd/format/contents.h>

namespace vcd::tools {

using Json = nlohmann::ordered_json;

std::string hex(const std::array<uint8_t, 16>& hash);
std::string hex(uint64_t value);
std::string printable(std::string_view name);  // control characters escaped, "(no name)" for none

Json describe_object(const ObjectContents& object);
Json describe_section(const SectionEntry& section);
Json describe_finding(const Finding& finding);
const char* method_name(Method method);
const char* guarantee(Method method);                    // a clause: what the classes promise
std::string object_summary(const ObjectRecord& record);  // several lines, indented by two spaces
// Two such lines; none for no hierarchy.
std::string hierarchy_summary(const ObjectRecord& record, const HierarchyView& hierarchy);
std::string horizon_summary(const HorizonView& horizon);  // likewise, one line

// The text of it; bytes that are not UTF-8 are replaced. indent -1: one line.
std::string json_text(const Json& json, int indent = -1);
void print_json(const Json& json);  // standard output, two spaces of indent

}  // namespace vcd::tools
