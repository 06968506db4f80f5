// A program on Embree that knows nothing of vcd: asks the shadow rays of one scene, and prints a 1 for each that is
// blocked, else a 0.
//
//   shadow_program SCENE QUERY
#include <embree3/rtcore.h>

#include <barrier>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "failing_memory.h"

namespace {

constexpr size_t kRays = 4096;
constexpr float kBlocked = -INFINITY;

struct Mesh {
  std::vector<float> positions;   // x, y, z
  std::vector<uint32_t> corners;  // 3 or 4 a face
};

Mesh sphere(unsigned corners, float x = 0) {
  constexpr uint32_t kRings = 24, kSegments = 48;
  Mesh mesh;
  for (uint32_t r = 0; r <= kRings; ++r)
    for (uint32_t s = 0; s < kSegments; ++s) {
      const double theta = M_PI * r / kRings, phi = 2 * M_PI * s / kSegments;
      mesh.positions.push_back(static_cast<float>(std::sin(theta) * std::cos(phi)) + x);
      mesh.positions.push_back(static_cast<float>(std::cos(theta)));
      mesh.positions.push_back(static_cast<float>(std::sin(theta) * std::sin(phi)));
    }
  for (uint32_t r = 0; r < kRings; ++r)
    for (uint32_t s = 0; s < kSegments; ++s) {
      const uint32_t a = r * kSegments + s, b = r * kSegments + (s + 1) % kSegments, c = b + kSegments,
                     d = a + kSegments;
      if (corners == 4) mesh.corners.insert(mesh.corners.end(), {a, b, c, d});
      else mesh.corners.insert(mesh.corners.end(), {a, b, d, c, d, b});
    }
  return mesh;
}

// As a program may hold it: more at each vertex than its position.
RTCGeometry add(RTCDevice device, RTCScene scene, const Mesh& mesh, unsigned corners = 3) {
  const RTCGeometry geometry =
      rtcNewGeometry(device, corners == 3 ? RTC_GEOMETRY_TYPE_TRIANGLE : RTC_GEOMETRY_TYPE_QUAD);
  const size_t count = mesh.positions.size() / 3, faces = mesh.corners.size() / corners;
  auto* positions = static_cast<float*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 5 * sizeof(float), count));
  for (size_t i = 0; i < count; ++i) {
    std::memcpy(positions + 5 * i, &mesh.positions[3 * i], 3 * sizeof(float));
    positions[5 * i + 3] = positions[5 * i + 4] = 0.5f;
  }
  void* indices =
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, corners == 3 ? RTC_FORMAT_UINT3 : RTC_FORMAT_UINT4,
                              corners * sizeof(uint32_t), faces);
  std::memcpy(indices, mesh.corners.data(), mesh.corners.size() * sizeof(uint32_t));
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);  // the scene holds it
  return geometry;
}

void move(RTCGeometry geometry, float x) {
  auto* positions = static_cast<float*>(rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0));
  for (size_t i = 0; i < 25 * 48; ++i) positions[5 * i] += x;
  rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
  rtcCommitGeometry(geometry);
}

RTCGeometry add_instance(RTCDevice device, RTCScene scene, RTCScene of, float x, float scale) {
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, of);
  const float transform[12] = {scale, 0, 0, 0, scale, 0, 0, 0, scale, x, 0, 0};
  rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, transform);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  return geometry;
}

void set_mask(RTCGeometry geometry, unsigned mask) {
  rtcSetGeometryMask(geometry, mask);
  rtcCommitGeometry(geometry);
}

void let_pass(const RTCFilterFunctionNArguments* arguments) {
  for (unsigned i = 0; i < arguments->N; ++i) arguments->valid[i] = 0;
}

struct Asked {
  std::vector<RTCRay> rays;
  RTCIntersectContext context;
  bool commit = true;  // the scene, before the rays are asked
};

// From around the scene to its middle, some of them short, some from inside.
std::vector<RTCRay> rays(float far = 4) {
  uint32_t state = 1;
  const auto uniform = [&] { return static_cast<float>((state = state * 1664525 + 1013904223) >> 8) * 0x1p-23f - 1; };
  std::vector<RTCRay> rays(kRays);
  for (RTCRay& ray : rays) {
    float from[3], to[3];
    for (float& x : from) x = uniform() * far;
    for (float& x : to) x = uniform() * 2;
    ray = {from[0], from[1], from[2], 0, to[0] - from[0], to[1] - from[1], to[2] - from[2], 0, 2, ~0u, 0, 0};
    if (uniform() > 0.8f) ray.tfar = 0.5f;
  }
  return rays;
}

using Build = std::function<void(RTCDevice, RTCScene, Asked&)>;

RTCScene committed_sphere(RTCDevice device) {
  const RTCScene scene = rtcNewScene(device);
  add(device, scene, sphere(3));
  rtcCommitScene(scene);
  return scene;
}

// Commits and asks, so that there is something to be out of date.
void ask_once(RTCScene scene, Asked& asked) {
  rtcCommitScene(scene);
  RTCRay ray = asked.rays[0];
  rtcOccluded1(scene, &asked.context, &ray);
}

void expect_error(RTCDevice device, RTCError expected) {
  if (const RTCError error = rtcGetDeviceError(device); error != expected)
    std::fprintf(stderr, "the device's error is %d, not %d\n", error, expected), std::exit(1);
}

const std::map<std::string, Build> kScenes = {
    {"mesh", [](RTCDevice device, RTCScene scene, Asked&) { add(device, scene, sphere(3)); }},
    {"quads", [](RTCDevice device, RTCScene scene, Asked&) { add(device, scene, sphere(4), 4); }},
    {"two",
     [](RTCDevice device, RTCScene scene, Asked&) { add(device, scene, sphere(3)), add(device, scene, sphere(3, 3)); }},
    {"instances",
     [](RTCDevice device, RTCScene scene, Asked&) {
       const RTCScene inner = committed_sphere(device);
       add_instance(device, scene, inner, -2, 0.75f), add_instance(device, scene, inner, 1, 1.5f);
       rtcReleaseScene(inner);
     }},
    {"inner-changed",
     [](RTCDevice device, RTCScene scene, Asked& asked) {
       const RTCScene inner = rtcNewScene(device);
       const RTCGeometry geometry = add(device, inner, sphere(3));
       rtcCommitScene(inner);
       const RTCGeometry instance = add_instance(device, scene, inner, 0, 1);
       ask_once(scene, asked);
       move(geometry, 2);
       rtcCommitScene(inner);
       rtcCommitGeometry(instance);
     }},
    {"mask-at-once",  // it counts without a commit of the scene
     [](RTCDevice device, RTCScene scene, Asked& asked) {
       const RTCGeometry geometry = add(device, scene, sphere(3));
       ask_once(scene, asked);
       set_mask(geometry, 0);
       asked.commit = false;
     }},
    {"inner-at-once",  // so does the commit of an instanced scene
     [](RTCDevice device, RTCScene scene, Asked& asked) {
       const RTCScene inner = rtcNewScene(device);
       const RTCGeometry geometry = add(device, inner, sphere(3));
       rtcCommitScene(inner);
       add_instance(device, scene, inner, 0, 1);
       ask_once(scene, asked);
       move(geometry, 0.5f);
       rtcCommitScene(inner);
       asked.commit = false;
     }},
    {"filter",
     [](RTCDevice device, RTCScene scene, Asked&) {
       const RTCGeometry geometry = add(device, scene, sphere(3));
       rtcSetGeometryOccludedFilterFunction(geometry, let_pass);
       rtcCommitGeometry(geometry);
     }},
    {"context-filter",
     [](RTCDevice device, RTCScene scene, Asked& asked) {
       rtcSetSceneFlags(scene, RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
       add(device, scene, sphere(3));
       asked.context.filter = let_pass;
     }},
    {"mask",
     [](RTCDevice device, RTCScene scene, Asked& asked) {
       set_mask(add(device, scene, sphere(3)), 6);
       for (size_t i = 0; i < kRays; ++i) asked.rays[i].mask = static_cast<uint32_t>(i);
     }},
    {"instance-mask",
     [](RTCDevice device, RTCScene scene, Asked& asked) {
       set_mask(add_instance(device, scene, committed_sphere(device), 0, 1), 6);
       for (size_t i = 0; i < kRays; ++i) asked.rays[i].mask = static_cast<uint32_t>(i);
     }},
    {"motion",
     [](RTCDevice device, RTCScene scene, Asked& asked) {
       const RTCGeometry geometry = add(device, scene, sphere(3));
       rtcSetGeometryTimeStepCount(geometry, 2);
       auto* later = static_cast<float*>(
           rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 1, RTC_FORMAT_FLOAT3, 5 * sizeof(float), 25 * 48));
       std::memcpy(later, rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0), 25 * 48 * 5 * sizeof(float));
       for (size_t i = 0; i < 25 * 48; ++i) later[5 * i] += 2;
       rtcCommitGeometry(geometry);
       for (size_t i = 0; i < kRays; ++i) asked.rays[i].time = static_cast<float>(i) / kRays;
     }},
    {"disabled",
     [](RTCDevice device, RTCScene scene, Asked& asked) {
       const RTCGeometry geometry = add(device, scene, sphere(3));
       add(device, scene, sphere(3, 3));
       ask_once(scene, asked);
       rtcDisableGeometry(geometry);
     }},
    {"detached",
     [](RTCDevice device, RTCScene scene, Asked& asked) {
       add(device, scene, sphere(3, 3)), add(device, scene, sphere(3));
       ask_once(scene, asked);
       rtcDetachGeometry(scene, 1);
     }},
    {"moved",
     [](RTCDevice device, RTCScene scene, Asked& asked) {
       const RTCGeometry geometry = add(device, scene, sphere(3));
       ask_once(scene, asked);
       move(geometry, 1.5f);
     }},
    {"attributes",  // what lies beside the positions changes, which is no change of the mesh
     [](RTCDevice device, RTCScene scene, Asked& asked) {
       const RTCGeometry geometry = add(device, scene, sphere(3));
       ask_once(scene, asked);
       auto* positions = static_cast<float*>(rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0));
       for (size_t i = 0; i < 25 * 48; ++i) positions[5 * i + 3] = static_cast<float>(i);
       move(geometry, 0);
     }},
    {"again",  // addresses come back
     [](RTCDevice device, RTCScene scene, Asked& asked) {
       for (int i = 0; i < 100; ++i) {
         const RTCScene other = rtcNewScene(device);
         add(device, other, sphere(i % 2 ? 3 : 4, static_cast<float>(i)), i % 2 ? 3 : 4);
         rtcCommitScene(other);
         rtcReleaseScene(other);
       }
       add(device, scene, sphere(3));
       ask_once(scene, asked);
     }},
    {"user",
     [](RTCDevice device, RTCScene scene, Asked&) {
       add(device, scene, sphere(3));
       const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
       rtcSetGeometryUserPrimitiveCount(geometry, 1);
       rtcSetGeometryBoundsFunction(
           geometry,
           [](const RTCBoundsFunctionArguments* arguments) { *arguments->bounds_o = {-4, -4, -4, 0, 4, 4, 4, 0}; },
           nullptr);
       rtcSetGeometryOccludedFunction(geometry, [](const RTCOccludedFunctionNArguments* arguments) {
         for (unsigned i = 0; i < arguments->N; ++i)
           if (arguments->valid[i] && RTCRayN_org_x(arguments->ray, arguments->N, i) > 0)
             RTCRayN_tfar(arguments->ray, arguments->N, i) = kBlocked;
       });
       rtcCommitGeometry(geometry);
       rtcAttachGeometry(scene, geometry);
     }},
    {"two-devices",  // each keeps its own first error
     [](RTCDevice device, RTCScene scene, Asked&) {
       const RTCDevice other = rtcNewDevice("threads=1");
       for (const RTCDevice each : {device, other}) {
         const RTCScene empty = rtcNewScene(each);
         rtcNewGeometry(each, static_cast<RTCGeometryType>(77));
         rtcCommitScene(empty);
         rtcAttachGeometry(empty, nullptr);
         rtcCommitScene(empty);
         rtcReleaseScene(empty);
       }
       expect_error(other, RTC_ERROR_UNKNOWN), expect_error(other, RTC_ERROR_NONE);
       expect_error(device, RTC_ERROR_UNKNOWN), expect_error(device, RTC_ERROR_NONE);
       rtcReleaseDevice(other);
       add(device, scene, sphere(3));
     }},
    {"refused",  // a buffer that lies askew, and one that is too short: Embree keeps the old ones
     [](RTCDevice device, RTCScene scene, Asked&) {
       static const float kAskew[1024] = {};
       const RTCGeometry geometry = add(device, scene, sphere(3));
       rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, kAskew, 1, 12, 300);
       expect_error(device, RTC_ERROR_INVALID_OPERATION), expect_error(device, RTC_ERROR_NONE);
       const RTCBuffer small = rtcNewBuffer(device, 36);
       rtcSetGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, small, 0, 12, 100'000'000);
       expect_error(device, RTC_ERROR_INVALID_ARGUMENT), expect_error(device, RTC_ERROR_NONE);
       rtcReleaseBuffer(small);
       rtcCommitGeometry(geometry);
     }},
    {"at-once",  // threads commit the same meshes
     [](RTCDevice device, RTCScene scene, Asked&) {
       std::barrier together(8);
       std::vector<std::thread> threads;
       for (int t = 0; t < 8; ++t)
         threads.emplace_back([&] {
           for (int i = 0; i < 20; ++i) {
             const RTCScene own = rtcNewScene(device);
             add(device, own, sphere(3, 4.f + static_cast<float>(i)));
             together.arrive_and_wait();
             rtcCommitScene(own);
             rtcReleaseScene(own);
           }
         });
       for (std::thread& thread : threads) thread.join();
       add(device, scene, sphere(3));
     }},
    {"no-memory",  // each time another allocation fails
     [](RTCDevice device, RTCScene scene, Asked& asked) {
       ask_once(scene, asked);
       for (size_t failing = 0; failing < 80; ++failing) {
         allocations_left = failing;
         const RTCScene inner = rtcNewScene(device), outer = rtcNewScene(device);
         const RTCGeometry geometry = add(device, inner, sphere(3));
         rtcCommitScene(inner);
         add_instance(device, outer, inner, 0, 1), add(device, outer, sphere(3, 3));
         rtcCommitScene(outer);
         allocations_left = SIZE_MAX;
         move(geometry, 0.5f);
         rtcCommitScene(inner);
         for (size_t i = 0; i < 64; ++i) {
           RTCRay ray = asked.rays[i];
           rtcOccluded1(outer, &asked.context, &ray);
           std::putchar(ray.tfar == kBlocked ? '1' : '0');
         }
         rtcReleaseScene(outer), rtcReleaseScene(inner);
       }
       add(device, scene, sphere(3));
     }},
    {"far",
     [](RTCDevice device, RTCScene scene, Asked& asked) { add(device, scene, sphere(3)), asked.rays = rays(1000); }},
};

template <class Rays, class Query>
void ask_packets(const Query& query, std::vector<RTCRay>& rays) {
  constexpr size_t kWidth = sizeof(Rays::tfar) / sizeof(float);
  for (size_t first = 0; first < rays.size(); first += kWidth) {
    Rays packet;
    alignas(64) int valid[kWidth];
    for (size_t i = 0; i < kWidth; ++i) {
      const RTCRay& ray = rays[first + i];
      valid[i] = (first + i) % 5 ? -1 : 0;
      packet.org_x[i] = ray.org_x, packet.org_y[i] = ray.org_y, packet.org_z[i] = ray.org_z;
      packet.dir_x[i] = ray.dir_x, packet.dir_y[i] = ray.dir_y, packet.dir_z[i] = ray.dir_z;
      packet.tnear[i] = ray.tnear, packet.tfar[i] = ray.tfar, packet.time[i] = ray.time, packet.mask[i] = ray.mask;
      packet.id[i] = packet.flags[i] = 0;
    }
    query(valid, &packet);
    for (size_t i = 0; i < kWidth; ++i) rays[first + i].tfar = packet.tfar[i];
  }
}

using Query = std::function<void(RTCScene, RTCIntersectContext*, std::vector<RTCRay>&)>;

void ask_1(RTCScene scene, RTCIntersectContext* context, std::vector<RTCRay>& rays) {
  for (RTCRay& ray : rays) rtcOccluded1(scene, context, &ray);
}

const std::map<std::string, Query> kQueries = {
    {"1", ask_1},
    {"4",
     [](RTCScene scene, RTCIntersectContext* context, std::vector<RTCRay>& rays) {
       ask_packets<RTCRay4>([&](const int* valid, RTCRay4* packet) { rtcOccluded4(valid, scene, context, packet); },
                            rays);
     }},
    {"8",
     [](RTCScene scene, RTCIntersectContext* context, std::vector<RTCRay>& rays) {
       ask_packets<RTCRay8>([&](const int* valid, RTCRay8* packet) { rtcOccluded8(valid, scene, context, packet); },
                            rays);
     }},
    {"16",
     [](RTCScene scene, RTCIntersectContext* context, std::vector<RTCRay>& rays) {
       ask_packets<RTCRay16>([&](const int* valid, RTCRay16* packet) { rtcOccluded16(valid, scene, context, packet); },
                             rays);
     }},
    {"1M",  // rays apart from one another, and not a multiple of anything
     [](RTCScene scene, RTCIntersectContext* context, std::vector<RTCRay>& rays) {
       std::vector<RTCRayHit> apart(rays.size());
       for (size_t i = 0; i < rays.size(); ++i) apart[i].ray = rays[i];
       rtcOccluded1M(scene, context, &apart[0].ray, static_cast<unsigned>(rays.size() - 3), sizeof(RTCRayHit));
       for (size_t i = 0; i < rays.size(); ++i) rays[i] = apart[i].ray;
     }},
    {"1Mp",
     [](RTCScene scene, RTCIntersectContext* context, std::vector<RTCRay>& rays) {
       std::vector<RTCRay*> pointers;
       for (RTCRay& ray : rays) pointers.push_back(&ray);
       rtcOccluded1Mp(scene, context, pointers.data(), static_cast<unsigned>(rays.size()));
     }},
    {"NM",
     [](RTCScene scene, RTCIntersectContext* context, std::vector<RTCRay>& rays) {
       std::vector<RTCRayHit16> packets(rays.size() / 16);
       const auto move = [&](bool in) {
         for (size_t i = 0; i < rays.size(); ++i)
           for (size_t m = 0; m < 12; ++m) {
             float& there = (&packets[i / 16].ray.org_x[0])[16 * m + i % 16];
             float& here = (&rays[i].org_x)[m];
             in ? std::memcpy(&there, &here, 4) : std::memcpy(&here, &there, 4);
           }
       };
       move(true);
       rtcOccludedNM(scene, context, reinterpret_cast<RTCRayN*>(packets.data()), 16,
                     static_cast<unsigned>(packets.size()), sizeof packets[0]);
       move(false);
     }},
    {"threads",  // others build and end scenes meanwhile
     [](RTCScene scene, RTCIntersectContext* context, std::vector<RTCRay>& rays) {
       std::thread builder([device = rtcGetSceneDevice(scene)] {
         for (int i = 0; i < 50; ++i) rtcReleaseScene(committed_sphere(device));
         rtcReleaseDevice(device);
       });
       const std::vector<RTCRay> some(rays.begin(), rays.begin() + 300);
       std::vector<std::thread> threads;
       for (size_t t = 0; t < 3; ++t)
         threads.emplace_back([scene, some, own = *context]() mutable {
           for (int i = 0; i < 20; ++i) {
             std::vector<RTCRay> copy = some;
             ask_1(scene, &own, copy);
           }
         });
       ask_1(scene, context, rays);
       for (std::thread& thread : threads) thread.join();
       builder.join();
     }},
};

}  // namespace

int main(int argc, char** argv) {
  const auto build = kScenes.find(argc == 3 ? argv[1] : "");
  const auto query = kQueries.find(argc == 3 ? argv[2] : "");
  if (build == kScenes.end() || query == kQueries.end()) return std::puts("shadow_program SCENE QUERY"), 1;
  const RTCDevice device = rtcNewDevice("threads=1");
  const RTCScene scene = rtcNewScene(device);
  Asked asked{rays(), {}};
  rtcInitIntersectContext(&asked.context);
  build->second(device, scene, asked);
  if (asked.commit) rtcCommitScene(scene);
  query->second(scene, &asked.context, asked.rays);
  for (const RTCRay& ray : asked.rays) std::putchar(ray.tfar == kBlocked ? '1' : '0');
  std::putchar('\n');
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
  return 0;
}
