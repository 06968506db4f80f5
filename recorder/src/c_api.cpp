#include <vcd/recorder/vcd_recorder.h>

#include <new>
#include <span>
#include <utility>
#include <vector>

#include <vcd/recorder/recorder.h>
#include <vcd/runtime/from_c.h>
#include <vcd/writer/demand.h>

// A vcd_recorder_thread is a vcd::Recorder::Thread.
struct vcd_recorder {
  vcd::Recorder recorder;
};

namespace {

using namespace vcd::in_c;

vcd::Recorder::Thread& of(vcd_recorder_thread* thread) { return *reinterpret_cast<vcd::Recorder::Thread*>(thread); }

vcd::RecordedInstance translate_instance(const vcd_recorded_instance& from) {
  vcd::RecordedInstance instance{};
  std::memcpy(instance.geometry_hash.data(), from.geometry_hash, sizeof from.geometry_hash);
  std::memcpy(instance.place.box_min, from.box_min, sizeof from.box_min);
  std::memcpy(instance.place.box_max, from.box_max, sizeof from.box_max);
  std::memcpy(&instance.place.to_world, from.to_world, sizeof from.to_world);
  return instance;
}

}  // namespace

vcd_result vcd_recorder_build(const vcd_recorded_instance* instances, size_t count, size_t most,
                              vcd_recorder** recorder, vcd_error* error) {
  if (!recorder) return fail(error, VCD_ERROR_USAGE, "recorder is null");
  *recorder = nullptr;
  if (!instances && count > 0) return fail(error, VCD_ERROR_USAGE, "instances is null");
  try {
    std::vector<vcd::RecordedInstance> all;
    const size_t stride = count > 0 ? size_of(instances[0]) : 0;
    const auto* const bytes = reinterpret_cast<const char*>(instances);
    for (size_t i = 0; i < count; ++i) {
      const auto& from = *reinterpret_cast<const vcd_recorded_instance*>(bytes + i * stride);
      if (!is_whole(from) || size_of(from) != stride)
        return fail(error, VCD_ERROR_USAGE, "instance " + std::to_string(i) + " is of another size");
      all.push_back(translate_instance(from));
    }
    auto built = vcd::Recorder::build(all, most == 0 ? vcd::Recorder::kDefaultMost : most);
    if (!built) return fail(error, built.error());
    *recorder = new vcd_recorder{std::move(*built)};
    return VCD_SUCCESS;
  } catch (const std::bad_alloc&) {
    return fail(error, VCD_ERROR_RUNTIME, "out of memory");
  }
}

void vcd_recorder_free(vcd_recorder* recorder) { delete recorder; }

vcd_recorder_thread* vcd_recorder_new_thread(vcd_recorder* recorder) try {
  return reinterpret_cast<vcd_recorder_thread*>(&recorder->recorder.thread());
} catch (const std::bad_alloc&) {
  return nullptr;
}

void vcd_recorder_asked(vcd_recorder_thread* thread, const vcd_segment* segments, size_t count, uint32_t self) {
  of(thread).asked(std::span(reinterpret_cast<const vcd::Segment*>(segments), count), self);
}
void vcd_recorder_asked_arrays(vcd_recorder_thread* thread, const vcd_segment_arrays* segments, uint32_t self) {
  of(thread).asked(translate(*segments), self);
}
void vcd_recorder_asked_quad(vcd_recorder_thread* thread, const vcd_quad_bundle* bundle, uint32_t self) {
  of(thread).asked(translate(*bundle), self);
}
void vcd_recorder_asked_sphere(vcd_recorder_thread* thread, const vcd_sphere_bundle* bundle, uint32_t self) {
  of(thread).asked(translate(*bundle), self);
}
void vcd_recorder_asked_point(vcd_recorder_thread* thread, const vcd_point_bundle* bundle, uint32_t self) {
  of(thread).asked(translate(*bundle), self);
}

vcd_result vcd_recorder_write(const vcd_recorder* recorder, const char* path, vcd_error* error) try {
  if (!path) return fail(error, VCD_ERROR_USAGE, "path is null");
  const auto written = vcd::write_demand(path, recorder->recorder.demand());
  if (!written) return fail(error, written.error());
  return VCD_SUCCESS;
} catch (const std::bad_alloc&) {
  return fail(error, VCD_ERROR_RUNTIME, "out of memory");
}
