// Random segments for the audit, from one seed.
#pragma once

#include <cstdint>
#include <random>

#include <vcd/baker/audit.h>

namespace vcd::baker {

class AuditLines {
 public:
  AuditLines(const PreparedMesh& mesh, AuditKind kind, uint64_t seed);
  Segment next();

 private:
  using Vec = std::array<double, 3>;
  double uniform() { return std::generate_canonical<double, 53>(random_); }
  Vec direction();  // uniform on the sphere
  Vec point_on_face(uint32_t face);
  Vec point_on_mesh();
  Segment through(const Vec& point, Vec along);  // from outside the box, beyond it on both sides
  void shorten(Segment& s);

  const PreparedMesh& mesh_;
  AuditKind kind_;
  std::mt19937_64 random_;
  Vec center_, half_;
  double radius_;
};

}  // namespace vcd::baker
