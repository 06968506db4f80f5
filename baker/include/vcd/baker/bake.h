// A mesh in; the tree, the hierarchy and the record of its sidecar out.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <vcd/baker/audit.h>
#include <vcd/baker/demand.h>
#include <vcd/baker/horizon.h>
#include <vcd/baker/mesh.h>
#include <vcd/baker/plan.h>
#include <vcd/baker/prepare.h>
#include <vcd/format/error.h>
#include <vcd/writer/writer.h>

namespace vcd::baker {

// The passes of a bake in their order. All but trace and classify are left out where there is nothing to do, and these
// two where no cell is to be classified.
enum class BakePass : uint8_t {
  hierarchy,   // boxes over the triangles, for what the cells leave unclassified
  horizons,    // above which slopes nothing stands, for rays that start on the object
  trace,       // the mesh in grid units, Embree's hierarchy over it, and the classifier
  plan,        // picks the depth
  divide,      // chooses the cells to divide, best first; for a demand only
  classify,    // asks the class of every cell, and stores equal blocks once
  demote,      // gives up classes until the tree fits the budget of bytes
  clearances,  // measures the empty space below the box's faces
  audit,       // holds answers of the tree against exact arithmetic
};
const char* name_of(BakePass pass);  // "hierarchy": a static string

struct BakeProgress {
  double fraction;  // of the pass `divide` or `classify`, 0 … 1
  uint64_t rays;    // traced so far
  double seconds;   // since that pass began
};

// The cells of an earlier bake, in its sidecar.
struct KnownTree {
  ObjectRecord record;
  TreeView tree;
};

struct BakeOptions {
  Method method = Method::hybrid;  // none: no cell is classified, and the file says that a sidecar would not pay
  // 1 … 8; 0: plan() picks it, and whether to bake at all. For a demand the deepest level, 2 … 8; 0: by what is
  // asked and the budget of bytes.
  uint32_t depth = 5;
  // sampled: rays a cell, 16, 81 or 256. hybrid: of a cell of the statistical tier, 81 or 256. 0: 256, but 81 for
  // hybrid where proofs of blocked hardly ever succeed, as in foliage.
  uint32_t samples = 0;
  uint64_t seed = 0;
  unsigned threads = 0;  // 0: all
  // Of a file with this object alone; 0: none, but kDefaultBudgetBytes for plan(), and for a demand kDemandBudgetBytes
  // beside hierarchy and horizons.
  uint64_t budget_bytes = 0;
  // From the call of bake() to the written file, on a quiet machine; 0: none. A quarter is kept for audit and writing.
  // When the rest is over, the cells that have no class yet are left unclassified.
  double budget_seconds = 0;
  // Looks where the segments of this mesh go (all but those that are kept out), best first, as long as the budgets
  // last; what nobody asks for stays as coarse as the top table, or as depth_elsewhere. Outlives the bake. Null:
  // everywhere.
  const Demand* demand = nullptr;
  // For a demand: first all cells are divided as far as whole blocks go down to this level; 0: none are.
  uint32_t depth_elsewhere = 0;
  // For a demand: cells of the same geometry that need not be classified again, from the same baker. They are used if
  // method, samples and seed were the same, for proofs and hybrid bakes; sampled ones are baked anew. What they divide
  // stays divided as far as the bytes last, after all that the demand asks.
  std::optional<KnownTree> known = {};
  bool hierarchy = true;  // it takes its bytes of the budget first; left out where it would take more than half
  // For renderers that can name the triangle that a ray starts on: 12 bytes a triangle of the source. Needs the
  // hierarchy; left out where it would answer less than kLeastHorizonShare (<vcd/baker/horizon.h>).
  bool horizons = false;
  bool embed_geometry = false;
  uint64_t audit_lines = 0;  // that the audit asks; 0: no audit

  std::function<void(BakePass)> on_pass;              // called from the caller's thread when a pass begins
  std::function<void(const BakeProgress&)> progress;  // called now and then, from one thread at a time
  std::function<bool()> stop;  // asked often, from many threads at once; true ends the bake with an error
};

// What programs that bake only to measure or to show let the audit ask: about a tenth of a second.
inline constexpr uint64_t kQuickAuditLines = 50'000;

// Raised whenever the same mesh and options give other bytes than before: what an older revision baked is not up to
// date. A test holds the hashes of some bakes against it.
inline constexpr unsigned kBakeRevision = 11;

// Of the budget of a file, what is kept for header, tables and names, and to round the tree's beginning up to a page.
inline constexpr uint64_t kBytesBesideTree = 8192;
inline constexpr uint64_t kDefaultBudgetBytes = uint64_t{4} << 20;
inline constexpr uint64_t kDemandBudgetBytes = uint64_t{2} << 20;

// For a demand: when so many bytes of a tree were filled, the next were expected to be asked for by so much weight
// each.
struct WorthOfBytes {
  uint64_t bytes;
  double asked_a_byte;
};

// One baked object. One that was moved from, or made without arrays, can only be assigned to or destroyed.
class BakedObject {
 public:
  struct Arrays;
  BakedObject();
  explicit BakedObject(std::unique_ptr<Arrays> arrays);  // for the baker itself
  BakedObject(BakedObject&&) noexcept;
  BakedObject& operator=(BakedObject&&) noexcept;
  ~BakedObject();

  // Both point into this object: use them before it is moved or destroyed.
  ObjectToWrite to_write() const;
  TreeView tree() const;

  std::string name;
  ObjectRecord record{};
  std::optional<Plan> plan;            // if the depth was left to it
  std::optional<DemandReport> demand;  // if it was baked for one; no proof was wrong
  std::optional<AuditReport> audit;    // if one was asked for and the object answers anything; no proof was wrong
  uint64_t rays = 0;                   // traced to classify cells
  uint64_t cells_classified = 0;       // for a demand: those that were not known
  std::vector<WorthOfBytes> worth;     // for a demand: what bytes were worth as they were filled, rising in bytes
  double seconds = 0;                  // of the passes classify, demote and clearances
  uint64_t bytes_before_demotion = 0;  // of the tree, before it was made to fit the budget
  uint64_t cells_demoted = 0;          // that had a class and lost it so
  bool out_of_time = false;            // some cells were not classified
  std::optional<HorizonShare> horizon_share;  // if horizons were asked for and could be built
  std::string without_horizons;               // why there are none though they were asked for, a clause; else empty
  std::string without_hierarchy;              // why there is none though it was asked for, a clause; else empty

 private:
  std::unique_ptr<Arrays> arrays_;
};

// Writes into a record what it says of the object's source and what the geometry does not decide: source_index, flags,
// shift. bake() has done so.
void describe_source(const PreparedMesh& mesh, ObjectRecord& record);

// What bakes of the mesh would cost and be worth; options.depth is not looked at. Errors as bake().
Result<Plan> plan(const PreparedMesh& mesh, const BakeOptions& options);

// Bakes one object. Without a budget of seconds, the same geometry and options give the same tree and record, whatever
// the number of threads, the order of vertices and triangles, or the file they came from.
//
// Errors: usage (an option out of range, a budget of bytes too small for the depth or the depth elsewhere, or a demand
// that asks nothing of the mesh); difference (the audit found a wrong proof: a fault of vcd, and the message holds
// lines that show it); runtime (out of memory, or stopped). Safe from any thread. Exceptions of the callbacks pass
// through.
Result<BakedObject> bake(const PreparedMesh& mesh, const BakeOptions& options);

// The welded mesh as a Draco bitstream without quantization, so that decoding it and preparing it again gives the same
// mesh. Empty on failure.
std::vector<std::byte> encode_geometry(const PreparedMesh& mesh);

// The mesh of a GEOM section. Draco is not safe on hostile bytes: for those of a stranger there is the second function,
// which decodes in a child process with limits; `name` says in messages what the bytes are.
Result<SourceMesh> decode_geometry(Bytes draco);
Result<SourceMesh> decode_geometry_isolated(Bytes draco, const std::string& name);

}  // namespace vcd::baker
