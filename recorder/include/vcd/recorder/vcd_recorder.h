/* The recorder in C: what a renderer asks becomes a demand, to bake sidecars for. The same as
 * <vcd/recorder/recorder.h>. Structs that may grow begin with their size, as in <vcd/runtime/vcd.h>. */
#ifndef VCD_RECORDER_VCD_RECORDER_H
#define VCD_RECORDER_VCD_RECORDER_H

#include <stddef.h>
#include <stdint.h>

#include <vcd/runtime/vcd.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct vcd_recorder vcd_recorder;
typedef struct vcd_recorder_thread vcd_recorder_thread;

/* In an array of them all have the size of the first. Of one object alone: one, with the identity. */
typedef struct vcd_recorded_instance {
  uint32_t size;
  uint8_t geometry_hash[16];    /* of the object; vc-info shows it */
  float box_min[3], box_max[3]; /* that holds the mesh, in its own frame */
  float to_world[12];           /* row-major 3 x 4 */
} vcd_recorded_instance;

/* most: segments that each thread keeps, 36 bytes each; 0: 262,144. On success *recorder must be given to
 * vcd_recorder_free. */
vcd_result vcd_recorder_build(const vcd_recorded_instance* instances, size_t count, size_t most,
                              vcd_recorder** recorder, vcd_error* error);
void vcd_recorder_free(vcd_recorder* recorder); /* NULL is fine */

/* A new buffer, for one thread; lives as long as the recorder. Safe from any thread. NULL: out of memory. */
vcd_recorder_thread* vcd_recorder_new_thread(vcd_recorder* recorder);

/* Segments in the world's frame, as they were asked. self: the instance that they begin on, or VCD_NO_INSTANCE: of it
 * they are not recorded. One thread at a time; no locks. */
void vcd_recorder_asked(vcd_recorder_thread* thread, const vcd_segment* segments, size_t count, uint32_t self);
void vcd_recorder_asked_arrays(vcd_recorder_thread* thread, const vcd_segment_arrays* segments, uint32_t self);
void vcd_recorder_asked_quad(vcd_recorder_thread* thread, const vcd_quad_bundle* bundle, uint32_t self);
void vcd_recorder_asked_sphere(vcd_recorder_thread* thread, const vcd_sphere_bundle* bundle, uint32_t self);
void vcd_recorder_asked_point(vcd_recorder_thread* thread, const vcd_point_bundle* bundle, uint32_t self);

/* Writes what was asked so far. No thread records meanwhile. VCD_ERROR_USAGE: nothing was asked of any instance. */
vcd_result vcd_recorder_write(const vcd_recorder* recorder, const char* path, vcd_error* error);

#ifdef __cplusplus
}
#endif
#endif
