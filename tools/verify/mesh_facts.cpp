#include "mesh_facts.h"

#include <algorithm>
#include <cmath>

namespace vcd::verify {
using namespace baker;
namespace {

bool is_padded(const ObjectRecord& record, const PreparedMesh& mesh) {
  double extent[3], low[3], high[3];
  for (int a = 0; a < 3; ++a) {
    extent[a] = static_cast<double>(record.box_max[a]) - record.box_min[a];
    low[a] = high[a] = mesh.positions[0][a];
    for (const Position& p : mesh.positions) {
      low[a] = std::min(low[a], static_cast<double>(p[a]));
      high[a] = std::max(high[a], static_cast<double>(p[a]));
    }
  }
  const double diagonal = std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
  for (int a = 0; a < 3; ++a) {
    const double margin = std::min(low[a] - record.box_min[a], record.box_max[a] - high[a]);
    if (margin < extent[a] * 0x1p-11 || extent[a] < diagonal * 1e-3) return false;
  }
  return true;
}

}  // namespace

void check_facts(const ObjectRecord& record, const PreparedMesh& mesh, const std::string& place, Outcome& outcome) {
  if (record.triangle_count != mesh.triangles.size() || record.vertex_count != mesh.positions.size()) {
    outcome.add(IssueId::mesh_counts, ErrorCode::invalid_file, place,
                "its triangle and vertex counts are not the mesh's");
  } else if (!is_padded(record, mesh)) {
    outcome.add(IssueId::box_padding, ErrorCode::invalid_file, place, "its box is not padded as it must be");
  }
}

}  // namespace vcd::verify
