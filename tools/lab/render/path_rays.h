// The shadow rays of a path tracer: next-event estimation on matte surfaces under area lights and the sky.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include <vcd/format/segment.h>
#include <vcd/runtime/look_up_policy.h>

#include "sampling.h"
#include "world.h"

namespace vcd::render {

inline constexpr uint32_t kMostBounces = 4;

// A shadow ray, in the world's frame.
struct PathRay {
  Segment segment;
  uint32_t surface;    // that it begins on: an instance, or kGroundSurface
  uint32_t primitive;  // of that instance's source mesh, or kNoPrimitive
  From from;           // the object's box it begins; in a scene of instances: outside, or self
  uint32_t path;
  uint32_t bounce;  // 1: at the surface that the camera sees
  Vec3 light;       // what the camera receives along the path if nothing blocks the ray
};

using Random = std::mt19937_64;
Sample2 random_sample(Random& random);

// What a path met first.
enum class Met : uint8_t { nothing, ground, object };

// Follows one path from the camera and appends its shadow rays. Surfaces are matte and two-sided. At each surface point
// one light is chosen, all alike, the sky being one of them, and a shadow ray goes to a random point of it: to a
// rectangle as a segment from 0 to 1, to the sky without an end. Those below the surface, or to a rectangle's back, are
// not cast. The path goes on where a ray meets something, in a direction that the cosine weighs, and ends after its
// last bounce. No answer to a shadow ray changes a path. The same random numbers give the same rays. Safe from any
// thread. bounces  surface points of the path, at most
Met trace_path(const World& world, Random& random, uint32_t path, Vec3 direction, uint32_t bounces,
               std::vector<PathRay>& rays);

struct PathSettings {
  size_t paths = 100'000;
  uint32_t bounces = kMostBounces;  // 1 … kMostBounces: surface points of a path, with a shadow ray each
  uint64_t seed = 1;
};

// Paths through a picture of three by two, in Morton order, as many as the next square number. The same world and
// settings give the same rays, path by path and bounce by bounce.
std::vector<PathRay> trace_paths(const World& world, const PathSettings& settings);

}  // namespace vcd::render
