// Counts what look-ups answer, for a thread that wants to know:
//
//   vcd::AnswerCounts counts;                            // one for each thread; add them up with +=
//   const auto tree = vcd::Counting(object, counts);     // asked in the place of `object`, which may be a vcd::Scene
//   bool dark = tree.occluded(segment, [&] { return my_bvh_occluded(segment); });
//
// The runtime itself counts nothing, so that who does not ask through Counting pays nothing. There is no lock and no
// global state: the counts are the caller's.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>

#include <vcd/runtime/scene.h>
#include <vcd/runtime/sidecar.h>

namespace vcd {

struct AnswerCounts {
  uint64_t clear = 0, blocked = 0;  // by look-ups
  uint64_t unclassified = 0;        // left to a hierarchy, the object's or the renderer's

  uint64_t asked() const { return clear + blocked + unclassified; }
  uint64_t answered() const { return clear + blocked; }

  void add(Visibility answer) {
    clear += answer == Visibility::clear, blocked += answer == Visibility::blocked;
    unclassified += answer == Visibility::unclassified;
  }
  void add(std::span<const Visibility> answers) {
    for (const Visibility answer : answers) add(answer);
  }
  // Of a bundle of `size` samples, as classify() gives it.
  void add(size_t size, std::span<const uint64_t> of_blocked, std::span<const uint64_t> of_unclassified) {
    uint64_t more_blocked = 0, more_unclassified = 0;
    for (size_t i = 0; i < (size + 63) / 64; ++i) {
      more_blocked += static_cast<uint64_t>(std::popcount(of_blocked[i]));
      more_unclassified += static_cast<uint64_t>(std::popcount(of_unclassified[i]));
    }
    blocked += more_blocked, unclassified += more_unclassified, clear += size - more_blocked - more_unclassified;
  }
  AnswerCounts& operator+=(const AnswerCounts& more) {
    clear += more.clear, blocked += more.blocked, unclassified += more.unclassified;
    return *this;
  }
};

// Asks an Object (kept by value) or a Scene, and counts; scene and counts must outlive it. The answers are those of
// `Asked`. One thread at a time, as the counts are its own.
//
// more...  what Asked::classify() takes besides: of a Scene a SceneQuery
template <class Asked>
class Counting {
 public:
  Counting(const Asked& asked, AnswerCounts& counts) : asked_(asked), counts_(counts) {}

  template <class... More>
  Visibility classify(const Segment& segment, const More&... more) const {
    const Visibility answer = asked_.classify(segment, more...);
    counts_.add(answer);
    return answer;
  }
  template <class... More>
  void classify(std::span<const Segment> segments, std::span<Visibility> answers, const More&... more) const {
    asked_.classify(segments, answers, more...);
    counts_.add(answers.first(segments.size()));
  }
  template <class Bundle, class... More>
  requires(std::is_same_v<Bundle, QuadBundle> || std::is_same_v<Bundle, SphereBundle>)  //
      void classify(const Bundle& bundle, std::span<uint64_t> blocked, std::span<uint64_t> unclassified,
                    const More&... more) const {
    asked_.classify(bundle, blocked, unclassified, more...);
    counts_.add(bundle.size(), blocked, unclassified);
  }
  // fallback() -> bool is asked for unclassified segments only. It may ask the hierarchies: [&] { return
  // object.occluded(segment); }.
  template <class Fallback>
  requires std::is_invocable_v<Fallback>
  bool occluded(const Segment& segment, Fallback&& fallback) const {
    const Visibility answer = classify(segment);
    return answer == Visibility::unclassified ? static_cast<bool>(std::forward<Fallback>(fallback)())
                                              : answer == Visibility::blocked;
  }

 private:
  std::conditional_t<std::is_same_v<Asked, Object>, Object, const Asked&> asked_;
  AnswerCounts& counts_;
};

}  // namespace vcd
