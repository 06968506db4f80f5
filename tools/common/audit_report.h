// An audit's figures as text and JSON.
#pragma once

#include <string>

#include <vcd/baker/audit.h>
#include <vcd/runtime/sidecar.h>

#include "describe.h"

namespace vcd::tools {

// "ox,oy,oz,t_min,dx,dy,dz,t_max" with digits enough to be read back exactly; what --segment takes.
std::string replayable(const Segment& segment);
// False if the text is not eight numbers.
bool parse_segment(const std::string& text, Segment& segment);

Json describe_audit(const AuditReport& report);
std::string audit_summary(const AuditReport& report);  // a table, indented by two spaces

// An object of a sidecar as an audit asks it. The object's sidecar outlives the function.
inline Answers answers_of(Object object) {
  return [object](std::span<const Segment> segments, std::span<Visibility> answers) {
    object.classify(segments, answers);
  };
}

}  // namespace vcd::tools
