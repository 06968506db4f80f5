// A mesh in, the tree and record of its sidecar out.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <vcd/baker/mesh.h>
#include <vcd/baker/plan.h>
#include <vcd/baker/prepare.h>
#include <vcd/format/error.h>
#include <vcd/writer/writer.h>

namespace vcd {

struct BakeProgress {
  double fraction;  // of the object, 0 … 1
  uint64_t rays;    // traced so far
  double seconds;   // since tracing began
};

struct BakeOptions {
  Method method = Method::hybrid;  // none: nothing is classified, and the file says that a sidecar would not pay
  uint32_t depth = 5;              // 1 … 8; 0: plan() picks it, and whether to bake at all
  // sampled: rays a cell, 16, 81 or 256. hybrid: of a cell of the statistical tier, 81 or 256. 0: 256, but 81 for
  // hybrid where proofs of blocked hardly ever succeed, as in foliage.
  uint32_t samples = 0;
  uint64_t seed = 0;
  unsigned threads = 0;       // 0: all
  uint64_t budget_bytes = 0;  // of a file with this object alone; 0: none, but kDefaultBudgetBytes for plan()
  // From the call of bake() to the written file, on a quiet machine; 0: none. A quarter is kept for audit and writing.
  // When the rest is over, what is not classified stays unclassified.
  double budget_seconds = 0;
  bool embed_geometry = false;
  bool blank = false;   // trace nothing and leave every cell unclassified: to measure what a look-up costs where it
                        // never helps
  uint32_t one_in = 1;  // classify one in so many cells of the top table, the same for all methods, and leave the
                        // others unclassified: to measure what a bake costs
  std::function<void(const BakeProgress&)> progress;  // called now and then, from one thread at a time
  std::function<bool()> stop;  // asked often, from many threads at once; true ends the bake with an error
};

// Raised whenever the same mesh and options give other bytes than before: what an older revision baked is not up to
// date. A test holds the hashes of some bakes against it.
inline constexpr unsigned kBakeRevision = 2;

inline constexpr uint64_t kDefaultBudgetBytes = uint64_t{4} << 20;

// One baked object. Moving it keeps every span of to_write() valid.
class BakedObject {
 public:
  BakedObject();
  BakedObject(BakedObject&&) noexcept;
  BakedObject& operator=(BakedObject&&) noexcept;
  ~BakedObject();

  ObjectToWrite to_write() const;  // points into this object
  TreeView tree() const;

  std::string name;
  ObjectRecord record{};
  std::optional<Plan> plan;  // if the depth was left to it
  uint64_t rays = 0;
  double seconds = 0;                  // of classifying and merging
  double seconds_above = 0;            // of that, for the cells above the top table, which `one_in` does not thin out
  uint64_t bytes_before_demotion = 0;  // of the tree, before it was made to fit the budget
  uint64_t cells_demoted = 0;          // that had a class and lost it so
  bool out_of_time = false;            // some cells were not classified

 private:
  friend Result<BakedObject> bake(const PreparedMesh&, const BakeOptions&);
  struct Arrays;
  std::unique_ptr<Arrays> arrays_;
};

// What bakes of the mesh would cost and be worth; options.depth is not looked at. Errors as bake().
Result<Plan> plan(const PreparedMesh& mesh, const BakeOptions& options);

// Bakes one object. Without a budget of seconds, the same geometry and options give the same tree and record, whatever
// the number of threads, the order of vertices and triangles, or the file they came from. Errors: usage (an option out
// of range); runtime (out of memory, or stopped).
Result<BakedObject> bake(const PreparedMesh& mesh, const BakeOptions& options);

// The welded mesh as a Draco bitstream without quantization, so that decoding it and preparing it again gives the same
// mesh. Empty on failure.
std::vector<std::byte> encode_geometry(const PreparedMesh& mesh);

// The mesh of a GEOM section. Draco is not safe on hostile bytes: for those of a stranger there is the second function,
// which decodes in a child process with limits; `name` says in messages what the bytes are.
Result<SourceMesh> decode_geometry(Bytes draco);
Result<SourceMesh> decode_geometry_isolated(Bytes draco, const std::string& name);

}  // namespace vcd
