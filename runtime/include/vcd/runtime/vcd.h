/* vcd in C: open a sidecar, classify segments. The same semantics as <vcd/runtime/sidecar.h>.
 *
 * Handles are opaque, const and immutable after vcd_open: any number of threads may query one at once. A vcd_object
 * lives as long as the sidecar it came from. Queries never fail, allocate or block.
 *
 * Structs that may grow begin with their size: sizeof the struct, or 0 for its first version, which is this one. Later
 * versions add members at the end; no more than `size` bytes are read, and what is not there counts as 0. A size below
 * the first version's is VCD_ERROR_USAGE, and asserted where a function has no result. 0 is the default of every
 * member, so that a struct of zeros, with what is needed filled in, does what most callers want. vcd_segment and
 * vcd_segment_arrays never grow. */
#ifndef VCD_RUNTIME_VCD_H
#define VCD_RUNTIME_VCD_H

#include <stddef.h>
#include <stdint.h>

#include <vcd/runtime/version.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum vcd_result {
  VCD_SUCCESS = 0,
  VCD_ERROR_USAGE = 1,        /* an argument is null, misaligned or out of range */
  VCD_ERROR_IO = 2,           /* the file cannot be opened or read */
  VCD_ERROR_INVALID_FILE = 3, /* the bytes are not a valid sidecar */
  VCD_ERROR_RUNTIME = 4,      /* out of memory */
  VCD_ERROR_UNSUPPORTED = 5   /* a version or a critical section that this library does not know */
} vcd_result;

typedef enum vcd_visibility { VCD_CLEAR = 0, VCD_BLOCKED = 1, VCD_UNCLASSIFIED = 2 } vcd_visibility;

/* All points origin + t * direction, t_min < t < t_max, in the object's own frame. 32 bytes. */
typedef struct vcd_segment {
  float origin[3];
  float t_min;
  float direction[3];
  float t_max;
} vcd_segment;

typedef struct vcd_sidecar vcd_sidecar;
typedef struct vcd_object vcd_object;

/* What of a file is checked before it is used. Queries are memory-safe after each of them. */
typedef enum vcd_check {
  VCD_CHECK_CHECKSUMS = 0, /* tables, indices, and every checksum: reads the whole file once */
  VCD_CHECK_BOUNDS = 1,    /* tables and indices only: faster to open; damage to cells is not noticed */
  VCD_CHECK_CANONICAL = 2  /* all that vc-verify checks of a file alone, counts of cells too: slow */
} vcd_check;

/* Whether vcd_occluded and its kin look up before they ask a hierarchy. */
typedef enum vcd_look_up_first {
  VCD_LOOK_UP_AS_BAKED = 0, /* where the baker found that it saves time */
  VCD_LOOK_UP_ALWAYS = 1,   /* but of segments from the object itself */
  VCD_LOOK_UP_NEVER = 2
} vcd_look_up_first;

typedef struct vcd_open_options {
  uint32_t size;
  int copy;           /* 0: memory-map; 1: read into memory, for storage that others may rewrite */
  vcd_check check;    /* 0: checksums */
  int proven_only;    /* 1: trust proofs only. Cells that are blocked by statistics alone, and all cells of objects that
                       * were baked by sampling, are unclassified. */
  const char* kernel; /* what classifies and traces: a name of vcd_kernel; NULL: the fastest */
  vcd_look_up_first look_up;
} vcd_open_options;

typedef struct vcd_error {
  uint32_t size;
  char message[500]; /* zero-terminated, cut where it does not fit */
} vcd_error;

/* "success", "invalid file", …: a static string for any value. */
const char* vcd_result_string(vcd_result result);

/* The name of the index-th kernel for arrays that this processor can run, fastest first; NULL past the end. */
const char* vcd_kernel(size_t index);

/* Opens a file. On success *sidecar must be given to vcd_close; on failure it is NULL.
 * path     zero-terminated, in the file system's encoding
 * options  NULL for the defaults; wrong: a size that is smaller than the first version's, a check that is none
 * error    NULL, or where the message goes */
vcd_result vcd_open(const char* path, const vcd_open_options* options, const vcd_sidecar** sidecar, vcd_error* error);

/* Opens a whole file that is already in memory; the caller keeps it alive and unchanged until vcd_close.
 * data     aligned to 8 bytes (64 avoids a copy of the trees); size bytes */
vcd_result vcd_open_buffer(const void* data, size_t size, const vcd_open_options* options, const vcd_sidecar** sidecar,
                           vcd_error* error);

void vcd_close(const vcd_sidecar* sidecar); /* NULL is fine */

size_t vcd_object_count(const vcd_sidecar* sidecar);
const vcd_object* vcd_object_at(const vcd_sidecar* sidecar, size_t index);          /* NULL past the end */
const vcd_object* vcd_object_by_name(const vcd_sidecar* sidecar, const char* name); /* NULL if there is none */
const vcd_object* vcd_object_by_hash(const vcd_sidecar* sidecar, const uint8_t hash[16]);

/* A mesh as a renderer holds it, for its geometry hash: <vcd/format/geometry_hash.h>. */
typedef struct vcd_mesh_buffers {
  uint32_t size;
  uint32_t corners;      /* of a face: 0 or 3; or 4, quads as Embree cuts them */
  const void* positions; /* three floats each, at any alignment */
  size_t position_count;
  size_t position_stride; /* bytes; 0: 12 */
  const void* indices;    /* `corners` each, at any alignment */
  size_t face_count;
  size_t index_stride; /* bytes; 0: no gaps */
  uint32_t index_size; /* bytes: 0 or 4; or 2 */
} vcd_mesh_buffers;

/* The hash that the baker would give. Copies and sorts the mesh: once a mesh, not once a frame.
 * VCD_ERROR_USAGE: a position is not finite, or an index out of range; VCD_ERROR_INVALID_FILE: no triangle has an area.
 * error    NULL, or where the message goes */
vcd_result vcd_geometry_hash(const vcd_mesh_buffers* mesh, uint8_t hash[16], vcd_error* error);

/* Folders of sidecars, found by the geometry that they are of: <vcd/runtime/sidecar_store.h>. */
typedef struct vcd_store vcd_store;

/* Looks for *.vcd in the folders and all below. On success *store must be given to vcd_store_close; on failure it is
 * NULL.
 * options  of every file, when it is opened; NULL for the defaults */
vcd_result vcd_store_open(const char* const* folders, size_t count, const vcd_open_options* options, vcd_store** store,
                          vcd_error* error);
void vcd_store_close(vcd_store* store); /* NULL is fine */

/* *object gets the object of that geometry, which lives as long as the store; NULL, with VCD_SUCCESS, where there is
 * none, and on failure. Its file is opened when it is first asked for. Any number of threads at once. */
vcd_result vcd_store_find(vcd_store* store, const uint8_t hash[16], const vcd_object** object, vcd_error* error);

size_t vcd_store_size(const vcd_store* store); /* different geometries */
/* Why the index-th of the files that were passed over was, zero-terminated, as long as the store lives; NULL past the
 * end. */
const char* vcd_store_passed_over(const vcd_store* store, size_t index);

/* The object's name, UTF-8, NOT zero-terminated; *length gets its bytes. Lives as long as the sidecar. */
const char* vcd_object_name(const vcd_object* object, size_t* length);

/* 0: every segment is unclassified, so there is no need to ask. */
int vcd_object_answers(const vcd_object* object);

vcd_visibility vcd_classify(const vcd_object* object, const vcd_segment* segment);

/* Many segments as structure of arrays; segment i is {origin[0 .. 2][i], t_min[i], direction[0 .. 2][i], t_max[i]}. */
typedef struct vcd_segment_arrays {
  const float* origin[3];
  const float* t_min;
  const float* direction[3];
  const float* t_max;
  size_t count;
} vcd_segment_arrays;

/* answers[i] gets the vcd_visibility of segments[i], as one byte, for i < count. */
void vcd_classify_array(const vcd_object* object, const vcd_segment* segments, size_t count, uint8_t* answers);
void vcd_classify_arrays(const vcd_object* object, const vcd_segment_arrays* segments, uint8_t* answers);

/* Segments from origin to samples corner + u[i] * edge_u + v[i] * edge_v of one light: <vcd/runtime/bundle.h>. */
typedef struct vcd_quad_bundle {
  uint32_t size;
  float origin[3];
  float corner[3], edge_u[3], edge_v[3];
  const float *u, *v;
  size_t count;
} vcd_quad_bundle;

/* Segments from origin to samples {x[i], y[i], z[i]} in or on a sphere. */
typedef struct vcd_sphere_bundle {
  uint32_t size;
  float origin[3];
  float centre[3], radius;
  const float *x, *y, *z;
  size_t count;
} vcd_sphere_bundle;

/* Bit i % 64 of blocked[i / 64] says that sample i is blocked, of unclassified[i / 64] that it is that; neither: clear.
 * Both have room for (count + 63) / 64 words. */
void vcd_classify_quad(const vcd_object* object, const vcd_quad_bundle* bundle, uint64_t* blocked,
                       uint64_t* unclassified);
void vcd_classify_sphere(const vcd_object* object, const vcd_sphere_bundle* bundle, uint64_t* blocked,
                         uint64_t* unclassified);

/* Segments from origin to samples origin + {x[i], y[i], z[i]}: of several lights, of a sky, of anything. */
typedef struct vcd_point_bundle {
  uint32_t size;
  float origin[3];
  const float *x, *y, *z;
  size_t count;
} vcd_point_bundle;

/* What look-ups answered, for who wants to know: zeros at first, one for each thread. Never grows. */
typedef struct vcd_answer_counts {
  uint64_t clear, blocked; /* by look-ups */
  uint64_t unclassified;   /* left to a hierarchy, the object's or the renderer's */
} vcd_answer_counts;

/* Adds the answers that a call of vcd_classify_array or its kin gave; and the bits that one of vcd_classify_quad or
 * vcd_classify_sphere gave for `count` samples. */
void vcd_count_answers(vcd_answer_counts* counts, const uint8_t* answers, size_t count);
void vcd_count_bundle(vcd_answer_counts* counts, const uint64_t* blocked, const uint64_t* unclassified, size_t count);

/* Where segments begin: outside the object's box, inside, or on the object itself. */
typedef enum vcd_from { VCD_FROM_OUTSIDE = 0, VCD_FROM_INSIDE = 1, VCD_FROM_SELF = 2 } vcd_from;

/* Whether the file holds the object's triangles in a hierarchy. Then the object needs no fallback: what no look-up
 * decides, the hierarchy does, exactly. Without one, the functions below end the program with a message. */
int vcd_object_has_hierarchy(const vcd_object* object);

/* 1: the object blocks the segment. */
int vcd_occluded(const vcd_object* object, const vcd_segment* segment, vcd_from from);

/* Bit i % 64 of blocked[i / 64] says that segment i is blocked: room for (count + 63) / 64 words. */
void vcd_occluded_array(const vcd_object* object, const vcd_segment* segments, size_t count, vcd_from from,
                        uint64_t* blocked);
void vcd_occluded_quad(const vcd_object* object, const vcd_quad_bundle* bundle, vcd_from from, uint64_t* blocked);
void vcd_occluded_sphere(const vcd_object* object, const vcd_sphere_bundle* bundle, vcd_from from, uint64_t* blocked);
void vcd_occluded_point(const vcd_object* object, const vcd_point_bundle* bundle, vcd_from from, uint64_t* blocked);

/* Segments that begin on the object itself, on the triangle of that number in its source: see Object::classify_self()
 * in <vcd/runtime/sidecar.h>. VCD_CLEAR, or VCD_UNCLASSIFIED; never wrong, whatever is given. */
int vcd_object_has_horizons(const vcd_object* object);
vcd_visibility vcd_classify_self(const vcd_object* object, const vcd_segment* segment, uint32_t primitive);
void vcd_classify_self_array(const vcd_object* object, const vcd_segment* segments, const uint32_t* primitives,
                             size_t count, uint8_t* answers);

/* 1: the object blocks the segment. What horizons leave unclassified the hierarchy decides, and there must be one. */
int vcd_occluded_self(const vcd_object* object, const vcd_segment* segment, uint32_t primitive);
void vcd_occluded_self_array(const vcd_object* object, const vcd_segment* segments, const uint32_t* primitives,
                             size_t count, uint64_t* blocked);
void vcd_occluded_self_quad(const vcd_object* object, const vcd_quad_bundle* bundle, uint32_t primitive,
                            uint64_t* blocked);
void vcd_occluded_self_sphere(const vcd_object* object, const vcd_sphere_bundle* bundle, uint32_t primitive,
                              uint64_t* blocked);
void vcd_occluded_self_point(const vcd_object* object, const vcd_point_bundle* bundle, uint32_t primitive,
                             uint64_t* blocked);

/* Scenes of instances: see <vcd/runtime/scene.h>, also for what is promised. Queries of one scene may run on any number
 * of threads at once, vcd_scene_set_transforms not beside them. */
typedef struct vcd_scene vcd_scene;

/* In an array of them all have the size of the first. */
typedef struct vcd_instance {
  uint32_t size;
  uint32_t mask;                /* met by queries whose mask shares a bit with it; 0: by all */
  const vcd_object* object;     /* NULL: always left to trace; its sidecar must outlive the scene */
  float box_min[3], box_max[3]; /* that holds the mesh, in its own frame; read only where object is NULL */
  float to_world[12];           /* row-major 3 x 4; all zero: a scale of 0, so that nothing meets it */
} vcd_instance;

/* What a scene does with an instance: InstanceUse in <vcd/runtime/scene.h>. */
typedef enum vcd_instance_use {
  VCD_INSTANCE_ASKED = 0, /* its sidecar is asked where a segment could meet its box */
  VCD_INSTANCE_LEFT = 1,  /* every segment that could meet its box is left to trace */
  VCD_INSTANCE_ABSENT = 2 /* no segment meets it */
} vcd_instance_use;

/* No instance is an error: see vcd_scene_use. kernel: as in vcd_open_options; NULL: the fastest. On success *scene must
 * be given to vcd_scene_free. */
vcd_result vcd_scene_build(const vcd_instance* instances, size_t count, const char* kernel, vcd_scene** scene,
                           vcd_error* error);
void vcd_scene_free(vcd_scene* scene); /* NULL is fine */

/* 12 floats an instance, for all of them. On failure (out of memory) nothing has changed. */
vcd_result vcd_scene_set_transforms(vcd_scene* scene, const float* to_world, vcd_error* error);

/* What becomes of an instance with its present transform. */
vcd_instance_use vcd_scene_use(const vcd_scene* scene, uint32_t instance);

/* Segments of an array or a bundle that could meet one instance. */
typedef struct vcd_unclassified_segments {
  uint32_t size; /* of the struct that the library has, which may be a later one */
  uint32_t instance;
  int in_world; /* 0: segments are in the object's frame. 1: in the world's, as they were asked, because the instance's
                 * transform has no inverse (it is flat, or not finite), or floats cannot hold them in the object's */
  /* t as in the world; at most 256, readable up to a multiple of 16. */
  vcd_segment_arrays segments;
  const uint32_t* indices; /* of the same segments in the query */
  uint8_t* blocked;        /* 0 for each of them: to become 1 where the instance blocks it */
} vcd_unclassified_segments;
typedef void (*vcd_trace_unclassified)(void* context, const vcd_unclassified_segments* left);

#define VCD_NO_INSTANCE 0xFFFFFFFFu

typedef struct vcd_scene_query {
  uint32_t size;
  uint32_t mask;           /* instances whose mask shares a bit with it; 0: all instances */
  const uint32_t* origins; /* the instance that each segment begins on, or VCD_NO_INSTANCE; of a bundle one; or NULL */
  const uint32_t* primitives; /* the triangle of that instance's object, as in vcd_classify_self; of a bundle one; or
                                 NULL */
} vcd_scene_query;

/* The look-ups alone, of one segment in the world's frame. mask: as in vcd_scene_query, 0 for all instances. origin:
 * the instance that the segment begins on, or VCD_NO_INSTANCE. */
vcd_visibility vcd_scene_classify(const vcd_scene* scene, const vcd_segment* segment, uint32_t mask, uint32_t origin);

/* 1: all instances that are not absent have a hierarchy, so that trace may be NULL below. */
int vcd_scene_has_hierarchies(const vcd_scene* scene);

/* 1: the segment is blocked, by look-ups or by hierarchies. mask and origin: as in vcd_scene_classify. */
int vcd_scene_occluded_one(const vcd_scene* scene, const vcd_segment* segment, uint32_t mask, uint32_t origin);

/* The same of a segment that begins on a triangle of the instance `origin`, as in vcd_classify_self. */
int vcd_scene_occluded_self(const vcd_scene* scene, const vcd_segment* segment, uint32_t mask, uint32_t origin,
                            uint32_t primitive);

/* Bit i % 64 of blocked[i / 64] becomes 1 where segment i is blocked, else 0: room for (count + 63) / 64 words. trace
 * is asked for what look-ups leave unclassified; NULL: the objects' own hierarchies are, and
 * vcd_scene_has_hierarchies must be 1. query: NULL for all instances and no origins. */
void vcd_scene_occluded(const vcd_scene* scene, const vcd_segment* segments, size_t count, const vcd_scene_query* query,
                        vcd_trace_unclassified trace, void* context, uint64_t* blocked);
void vcd_scene_occluded_quad(const vcd_scene* scene, const vcd_quad_bundle* bundle, const vcd_scene_query* query,
                             vcd_trace_unclassified trace, void* context, uint64_t* blocked);
void vcd_scene_occluded_sphere(const vcd_scene* scene, const vcd_sphere_bundle* bundle, const vcd_scene_query* query,
                               vcd_trace_unclassified trace, void* context, uint64_t* blocked);
void vcd_scene_occluded_point(const vcd_scene* scene, const vcd_point_bundle* bundle, const vcd_scene_query* query,
                              vcd_trace_unclassified trace, void* context, uint64_t* blocked);

#ifdef __cplusplus
}
#endif
#endif
