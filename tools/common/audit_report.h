// An audit's figures as text and JSON.
#pragma once

#include <string>

#include <vcd/baker/audit.h>
#include <vcd/runtime/sidecar.h>

#include "describe.h"

namespace vcd::tools {

Json describe_audit(const baker::AuditReport& report);
std::string audit_summary(const baker::AuditReport& report);  // a table, indented by two spaces

// An object of a sidecar as an audit asks it. The object's sidecar outlives the function.
inline baker::Answers answers_of(Object object) {
  return [object](std::span<const Segment> segments, std::span<Visibility> answers) {
    object.classify(segments, answers);
  };
}

}  // namespace vcd::tools
