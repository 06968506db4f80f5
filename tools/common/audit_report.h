// An audit's figures as text and JSON.
#pragma once

#include <string>

#include <vcd/baker/audit.h>

#include "describe.h"

namespace vcd {

// "ox,oy,oz,t_min,dx,dy,dz,t_max" with digits enough to be read back exactly; what --segment takes.
std::string replayable(const Segment& segment);
// False if the text is not eight numbers.
bool parse_segment(const std::string& text, Segment& segment);

Json describe_audit(const AuditReport& report);
std::string audit_summary(const AuditReport& report);  // a table, indented by two spaces

// Wrong answers among the kinds that are drawn without looking at the mesh: uniform and chords.
AuditCounts undirected(const AuditReport& report);

}  // namespace vcd
