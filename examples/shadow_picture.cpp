// A renderer in one file: a mesh on a floor under a square light, with soft shadows. Each shadow ray from the floor
// asks the sidecar first, and Embree only if the sidecar cannot tell. Prints what that saved, and writes the picture.
//
//   vc-bake tree.glb && shadow-picture tree.glb tree.glb.vcd picture.bmp
#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <embree3/rtcore.h>

#include <vcd/baker/ingest.h>
#include <vcd/baker/tracer.h>
#include <vcd/runtime/embree.h>
#include <vcd/runtime/sidecar.h>

namespace {

constexpr int kWidth = 480, kHeight = 360, kLightRows = 8;
constexpr size_t kSamples = 64;  // of the light: a bit each

using Vec = std::array<float, 3>;
Vec operator+(Vec a, Vec b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vec operator-(Vec a, Vec b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec operator*(float s, Vec a) { return {s * a[0], s * a[1], s * a[2]}; }
float dot(Vec a, Vec b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec cross(Vec a, Vec b) { return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}; }
Vec unit(Vec a) { return 1 / std::sqrt(dot(a, a)) * a; }

// Where a camera ray ends.
struct Point {
  Vec position, normal;  // the normal on the side of the light
  bool on_mesh;
};

// The mesh stands on the floor, y is up; the light hangs above and to the left of it.
struct World {
  RTCScene mesh;
  Vec centre, eye, light;
  float floor, size;

  World(RTCScene scene, const vcd::ObjectRecord& object) : mesh(scene), floor(object.box_min[1]), size(0) {
    for (size_t a = 0; a < 3; ++a) {
      centre[a] = (object.box_min[a] + object.box_max[a]) / 2;
      size = std::max(size, object.box_max[a] - object.box_min[a]);
    }
    eye = centre + size * Vec{0.3f, 0.7f, 1.5f};
    light = centre + size * Vec{-1.3f, 1.6f, 0.5f};
  }

  // What the camera sees at a pixel; false: the sky.
  bool see(int x, int y, Point& point) const {
    const Vec ahead = unit(centre - eye), right = unit(cross(ahead, {0, 1, 0})), up = cross(right, ahead);
    const Vec way = unit(ahead + (static_cast<float>(x) - kWidth / 2) / kHeight * right +
                         (kHeight / 2 - static_cast<float>(y)) / kHeight * up);
    const float to_floor = way[1] < 0 ? (floor - eye[1]) / way[1] : std::numeric_limits<float>::infinity();
    RTCRayHit ray{};
    ray.ray = vcd::to_ray({{eye[0], eye[1], eye[2]}, 0, {way[0], way[1], way[2]}, to_floor});
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(mesh, &context, &ray);
    point.on_mesh = ray.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    point.normal = point.on_mesh ? unit({ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z}) : Vec{0, 1, 0};
    point.position = eye + ray.ray.tfar * way;
    if (dot(point.normal, light - point.position) < 0) point.normal = -1.0f * point.normal;
    return std::isfinite(ray.ray.tfar);
  }
};

// The samples of the light, row by row, as shares of its two edges.
struct Samples {
  std::array<float, kSamples> u, v;
  Samples() {
    for (size_t i = 0; i < kSamples; ++i) {
      u[i] = (static_cast<float>(i % kLightRows) + 0.5f) / kLightRows;
      v[i] = (static_cast<float>(i / kLightRows) + 0.5f) / kLightRows;
    }
  }
};

// How many samples of the light a point sees. sidecar: asked first if it is not null. Rays that start on the mesh
// itself go to Embree at once, because a look-up seldom answers them.
size_t visible_samples(const World& world, const Samples& samples, const Point& point, const vcd::Object* sidecar,
                       uint64_t& traced) {
  const float edge = 0.5f * world.size;
  const auto [px, py, pz] = point.position + 1e-4f * world.size * point.normal;
  const auto [lx, ly, lz] = world.light - Vec{edge / 2, 0, edge / 2};
  const vcd::QuadBundle rays{{px, py, pz}, {lx, ly, lz}, {edge, 0, 0}, {0, 0, edge}, samples.u, samples.v};

  uint64_t blocked = 0, unclassified = ~uint64_t{0};
  if (sidecar && !point.on_mesh) sidecar->classify(rays, {&blocked, 1}, {&unclassified, 1});

  std::array<vcd::Segment, kSamples> left;
  size_t count = 0;
  for (uint64_t rest = unclassified; rest != 0; rest &= rest - 1)
    left[count++] = segment_of(rays, static_cast<size_t>(std::countr_zero(rest)));
  std::array<uint8_t, kSamples> hit;
  vcd::occluded(world.mesh, {}, std::span(left).first(count), hit.data());
  traced += count;
  return kSamples - static_cast<size_t>(std::popcount(blocked) +
                                        std::count(hit.begin(), hit.begin() + static_cast<std::ptrdiff_t>(count), 1));
}

// One number for each pixel of the floor or the mesh, row by row from the top.
struct Shadows {
  std::vector<size_t> visible;
  uint64_t traced = 0;
  double seconds = 0;
};

Shadows cast_shadows(const World& world, const std::vector<Point>& points, const vcd::Object* sidecar) {
  Shadows shadows;
  const Samples samples;
  const auto start = std::chrono::steady_clock::now();
  for (const Point& point : points)
    shadows.visible.push_back(visible_samples(world, samples, point, sidecar, shadows.traced));
  shadows.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return shadows;
}

bool write_bmp(const std::string& path, const std::vector<std::array<uint8_t, 3>>& pixels) {
  std::array<uint8_t, 54> header{'B', 'M'};
  const auto put = [&](size_t at, uint32_t value) {
    for (size_t k = 0; k < 4; ++k) header[at + k] = static_cast<uint8_t>(value >> 8 * k);
  };
  put(2, 54 + 3 * kWidth * kHeight), put(10, 54), put(14, 40), put(18, kWidth), put(22, kHeight), put(26, 1 | 24 << 16);
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(header.data()), header.size());
  for (int y = kHeight - 1; y >= 0; --y)  // bottom row first
    file.write(reinterpret_cast<const char*>(&pixels[static_cast<size_t>(y) * kWidth]), 3 * kWidth);
  return static_cast<bool>(file.flush());
}

int fail(const vcd::Error& error) { return std::fprintf(stderr, "%s\n", error.message.c_str()), 1; }

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return std::fprintf(stderr, "usage: shadow-picture MESH SIDECAR PICTURE.bmp\n"), 1;
  const auto meshes = vcd::baker::ingest_isolated(argv[1]);
  if (!meshes) return fail(meshes.error());
  const vcd::baker::SourceMesh& mesh = meshes->meshes[0];
  const auto tracer = vcd::baker::Tracer::build(mesh.positions, mesh.triangles, vcd::baker::TraceMode::fast);
  if (!tracer) return fail(tracer.error());
  const auto sidecar = vcd::Sidecar::open(argv[2]);
  if (!sidecar) return fail(sidecar.error());
  const vcd::Object object = sidecar->object(0);

  const World world(tracer->scene(), object.record());
  std::vector<Point> points;
  std::vector<size_t> pixel_of_point;
  for (int i = 0; i < kWidth * kHeight; ++i) {
    Point point;
    if (!world.see(i % kWidth, i / kWidth, point)) continue;
    points.push_back(point);
    pixel_of_point.push_back(static_cast<size_t>(i));
  }

  const Shadows alone = cast_shadows(world, points, nullptr), with = cast_shadows(world, points, &object);

  std::vector<std::array<uint8_t, 3>> pixels(kWidth * kHeight, {235, 215, 190});  // blue, green, red
  size_t different = 0;
  for (size_t p = 0; p < points.size(); ++p) {
    different += alone.visible[p] != with.visible[p];
    const Vec to_light = unit(world.light - points[p].position);
    const float cosine = dot(points[p].normal, to_light);
    const float light = 0.2f + 0.8f * cosine * static_cast<float>(with.visible[p]) / static_cast<float>(kSamples);
    const Vec colour = points[p].on_mesh ? Vec{70, 170, 90} : Vec{190, 200, 205};
    for (size_t c = 0; c < 3; ++c) pixels[pixel_of_point[p]][c] = static_cast<uint8_t>(colour[c] * std::sqrt(light));
  }
  if (!write_bmp(argv[3], pixels)) return std::fprintf(stderr, "%s: cannot be written\n", argv[3]), 1;
  std::printf("Embree alone:      %9llu rays traced, %.2f s\n", static_cast<unsigned long long>(alone.traced),
              alone.seconds);
  std::printf("sidecar, Embree:   %9llu rays traced, %.2f s; %zu of %zu pixels differ\n",
              static_cast<unsigned long long>(with.traced), with.seconds, different, points.size());
  std::printf("%s\n", argv[3]);
}
