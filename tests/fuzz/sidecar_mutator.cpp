#include "fuzz/sidecar_mutator.h"

#include <bit>
#include <limits>
#include <random>

#include <vcd/format/contents.h>
#include <vcd/format/tree_statistics.h>

#include "fuzz/fuzz.h"
#include "fuzz/loose_sidecar.h"

namespace vcd::fuzz {
namespace {

// Floats on which arithmetic stumbles. Others come from libFuzzer's own changes.
constexpr float kInfinity = std::numeric_limits<float>::infinity(), kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kHostile[] = {0.0f,       -0.0f,           1.0f,      -1.0f,      0.5f,    256.0f,  0x1p-149f,
                              -0x1p-126f, 0x1p-100f,       0x1p-40f,  0x1p-20f,   0x1p17f, 0x1p24f, 0x1p100f,
                              -0x1p100f,  0x1.fffffep127f, kInfinity, -kInfinity, kNaN};

class Mutation {
 public:
  Mutation(LooseSidecar& sidecar, unsigned int seed) : sidecar_(sidecar), random_(seed) {}

  void bend(bool with_segments) {
    if (with_segments && below(2) == 0) return bend_tail();
    if (sidecar_.sections.empty() || below(16) == 0) return bend_table();
    LooseSection& section = sidecar_.sections[below(sidecar_.sections.size())];
    switch (section.entry.type) {
      case kSectionObjects: return bend_in_place(section.logical);
      case kSectionTree: return below(8) == 0 ? bend_in_place(section.logical) : bend_tree(section);
      case kSectionHierarchy: return below(2) ? bend_in_place(section.logical) : bend_hierarchy(section.logical);
      case kSectionHorizon: return bend_in_place(section.logical);
      default: return below(2) ? bend_in_place(section.logical) : bend_freely(section.logical, 64);
    }
  }

 private:
  size_t below(size_t n) { return random_() % n; }

  static void bend_freely(Buffer& bytes, size_t more) {
    const size_t before = bytes.size();
    bytes.resize(before + more);
    bytes.resize(LLVMFuzzerMutate(bytes.data(), before, bytes.size()));
  }

  // Keeps the size; half of the time one float becomes a hostile one.
  void bend_in_place(Buffer& bytes) {
    if (bytes.size() >= 4 && below(2)) {
      std::memcpy(bytes.data() + 4 * below(bytes.size() / 4), &kHostile[below(std::size(kHostile))], 4);
    } else if (!bytes.empty()) {
      const size_t begin = below(bytes.size()), length = std::min<size_t>(bytes.size() - begin, 1 + below(64));
      LLVMFuzzerMutate(bytes.data() + begin, length, length);
    }
  }

  void bend_tail() {
    if (!sidecar_.tail.empty() && below(3)) return bend_in_place(sidecar_.tail);
    bend_freely(sidecar_.tail, 128);
  }

  // A word becomes an index that a tree of this size may hold, or a brick gets other cells.
  void bend_tree(LooseSection& section) {
    const LooseSection* objects = sidecar_.first_of(kSectionObjects);
    const uint64_t record_at = uint64_t{section.entry.object} * sizeof(ObjectRecord);
    if (!objects || record_at + sizeof(ObjectRecord) > objects->logical.size()) return;
    ObjectRecord record;
    std::memcpy(&record, objects->logical.data() + record_at, sizeof record);
    Buffer& bytes = section.logical;
    const uint64_t bricks = record.brick_count * kBrickBytes;
    if (bricks == 0 || bricks > bytes.size()) return;
    const size_t words = (bytes.size() - bricks) / 4;
    for (size_t n = 1 + below(8); n > 0; --n) {
      if (words > 0 && below(2)) {
        const auto index = static_cast<uint32_t>(
            below(std::max<uint64_t>(*std::ranges::max_element(record.block_counts), record.brick_count)));
        std::memcpy(bytes.data() + 4 * below(words), &index, 4);
      } else {
        bytes[bytes.size() - 1 - below(bricks)] = static_cast<uint8_t>(random_());
      }
    }
  }

  // A word becomes one that a child may be.
  void bend_hierarchy(Buffer& bytes) {
    constexpr uint32_t kFlags[] = {0, kLeafChild, kLeafChild | kLargeChild};
    const auto child = static_cast<uint32_t>(below(bytes.size() / kUnitBytes + 1)) | kFlags[below(std::size(kFlags))];
    if (bytes.size() >= 4) std::memcpy(bytes.data() + 4 * below(bytes.size() / 4), &child, 4);
  }

  void bend_table() {
    auto& sections = sidecar_.sections;
    if (sections.empty() || below(4) == 0) return bend_in_place_as_bytes(sidecar_.header.version_minor);
    const size_t at = below(sections.size());
    switch (below(6)) {
      case 0: sections.push_back(sections[at]); break;
      case 1: sections.erase(sections.begin() + static_cast<std::ptrdiff_t>(at)); break;
      case 2: std::swap(sections[at], sections[below(sections.size())]); break;
      case 3: sections[at].entry.storage ^= 1; break;
      case 4: sections[at].entry.alignment ^= below(2) ? 8 ^ 4096 : 8 ^ 64; break;
      default: bend_in_place_as_bytes(sections[at].entry); break;
    }
  }

  template <class T>
  void bend_in_place_as_bytes(T& value) {
    Buffer bytes(sizeof value);
    std::memcpy(bytes.data(), &value, sizeof value);
    bend_in_place(bytes);
    std::memcpy(&value, bytes.data(), sizeof value);
  }

  LooseSidecar& sidecar_;
  std::minstd_rand random_;
};

// Where the file can be read at all, writes into its records what its trees hold, so that a validator agrees.
void recount(LooseSidecar& sidecar) {
  LooseSidecar alone = sidecar;
  alone.tail.clear();
  const Buffer bytes = alone.join();
  std::vector<Finding> findings;
  const auto contents = read_sidecar(std::as_bytes(std::span(bytes)), CheckLevel::bounds, findings);
  LooseSection* objects = sidecar.first_of(kSectionObjects);
  if (!contents || !objects) return;
  for (size_t i = 0; i < contents->objects.size(); ++i) {
    const TreeStatistics statistics = measure_tree(contents->objects[i].tree);
    ObjectRecord record = *contents->objects[i].record;
    std::copy_n(statistics.cells.begin(), 3, record.cells);
    record.statistical_cells = statistics.cells[3];
    record.nodes_unfolded = statistics.nodes_unfolded;
    record.nodes_folded = statistics.nodes_folded;
    record.nodes_shared = statistics.nodes_shared;
    std::memcpy(objects->logical.data() + i * sizeof record, &record, sizeof record);
  }
}

}  // namespace

size_t mutate_sidecar(uint8_t* data, size_t size, size_t max_size, unsigned int seed, bool with_segments) {
  std::minstd_rand random(seed);
  const auto way = random() % 8;
  std::optional<LooseSidecar> sidecar = way > 1 ? LooseSidecar::parse({data, size}) : std::nullopt;
  if (sidecar) {
    Mutation(*sidecar, static_cast<unsigned int>(random())).bend(with_segments);
    if (way > 3) recount(*sidecar);
    const Buffer bytes = sidecar->join();
    if (bytes.size() <= max_size) {
      std::memcpy(data, bytes.data(), bytes.size());
      return bytes.size();
    }
  }
  size = LLVMFuzzerMutate(data, size, max_size);
  if (way > 0) seal({data, size});
  return size;
}

}  // namespace vcd::fuzz
