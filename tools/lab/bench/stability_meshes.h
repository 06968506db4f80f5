// Meshes and segments at which methods fail.
#pragma once

#include <functional>
#include <random>
#include <string>
#include <vector>

#include <vcd/baker/prepare.h>
#include <vcd/format/segment.h>

namespace vcd::bench {

baker::SourceMesh stability_sphere(uint32_t rings = 12, uint32_t segments = 20);
baker::SourceMesh stability_soup(uint32_t triangles);  // in a unit cube, edges of about a tenth
baker::SourceMesh stability_slivers(uint32_t triangles, float aspect);
baker::SourceMesh scaled(baker::SourceMesh mesh, const baker::Position& factor);
baker::SourceMesh shifted(baker::SourceMesh mesh, const baker::Position& by);

// Open, closed, inverted, self-intersecting, duplicated, T-junctioned, bow-tie, non-manifold, Möbius strip, one
// triangle, soup.
std::vector<std::pair<std::string, baker::SourceMesh>> stability_kinds(uint32_t soup_triangles);

using Random = std::mt19937_64;

// How segments are drawn. All are in the mesh's own frame.
using SegmentMaker = std::function<Segment(const baker::PreparedMesh&, Random&)>;

// Likewise of segments that begin on the mesh; sets the triangle.
using SelfSegmentMaker = std::function<Segment(const baker::PreparedMesh&, Random&, uint32_t& triangle)>;
// From above a triangle, so high in its longest edges, on either side, into that half-space: by an offset along the
// normal, or by t_min. Every fourth foot is at an edge or a corner, or beside it.
SelfSegmentMaker above_a_triangle(double height);

// Through a random point of the box, in a random direction, from `boxes` boxes away.
Segment through_the_box(const baker::PreparedMesh& mesh, Random& random, double boxes);

// By name: axis, in-face, box-edge, box-corner, grazing, vertex, edge, end-on-surface, end-on-box, end-inside,
// end-outside.
std::vector<std::pair<std::string, SegmentMaker>> segment_kinds();

}  // namespace vcd::bench
