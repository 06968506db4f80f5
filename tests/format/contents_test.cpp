// The reader on damaged bytes: every prefix, every flipped bit of the tables, every finding of the table.
#include <vcd/format/contents.h>

#include <cstdlib>
#include <functional>
#include <limits>
#include <memory>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include <xxhash.h>
#include <zstd.h>

#include "support/files.h"
#include "support/meshes.h"
#include "support/special_floats.h"

namespace vcd::test {
using namespace baker;
namespace {

using Buffer = std::vector<std::byte>;

constexpr CheckLevel kLevels[] = {CheckLevel::bounds, CheckLevel::checksums, CheckLevel::canonical};

// Reads a copy that ends exactly where the bytes end, so that AddressSanitizer sees every step too far.
std::vector<Finding> findings_of(Bytes bytes, CheckLevel level = CheckLevel::canonical) {
  const std::unique_ptr<std::byte[]> exact(new std::byte[bytes.size()]);
  std::copy(bytes.begin(), bytes.end(), exact.get());
  std::vector<Finding> findings;
  const auto contents = read_sidecar({exact.get(), bytes.size()}, level, findings);
  EXPECT_EQ(contents.has_value(), !has_error(findings));
  for (const Finding& finding : findings) EXPECT_LE(finding.offset, bytes.size()) << describe(finding);
  return findings;
}

bool found(std::span<const Finding> findings, FindingId id) {
  return std::any_of(findings.begin(), findings.end(), [&](const Finding& f) { return f.id == id; });
}

// A file to damage. seal() makes the checksums fit again, so that the damage behind them is what is found.
struct FileToDamage {
  Buffer bytes;

  FileHeader& header() { return *reinterpret_cast<FileHeader*>(bytes.data()); }
  SectionEntry& section(uint32_t type) {
    for (uint32_t i = 0;; ++i) {
      auto& entry = reinterpret_cast<SectionEntry*>(bytes.data() + sizeof(FileHeader))[i];
      if (entry.type == type) return entry;
    }
  }
  ObjectRecord& object(uint32_t index = 0) {
    return reinterpret_cast<ObjectRecord*>(bytes.data() + section(kSectionObjects).offset)[index];
  }
  uint32_t* tree() { return reinterpret_cast<uint32_t*>(bytes.data() + section(kSectionTree).offset); }
  uint8_t* brick(uint32_t index) {
    return reinterpret_cast<uint8_t*>(tree()) + tree_shape(object().depth).top_bytes() + index * kBrickBytes;
  }
  HierarchyView hierarchy() { return {bytes.data() + section(kSectionHierarchy).offset}; }
  HierarchyHeader& hierarchy_header() { return const_cast<HierarchyHeader&>(hierarchy().header()); }
  HierarchyNode& hierarchy_root() { return const_cast<HierarchyNode&>(hierarchy().node(kRootUnit)); }
  HorizonHeader& horizon() { return *reinterpret_cast<HorizonHeader*>(bytes.data() + section(kSectionHorizon).offset); }
  HorizonEntry& horizon_entry(size_t i) { return reinterpret_cast<HorizonEntry*>(&horizon() + 1)[i]; }
  SmallLeaf& hierarchy_leaf() { return const_cast<SmallLeaf&>(hierarchy().small_leaf(hierarchy_root().child[0])); }

  void seal() {
    auto* table = reinterpret_cast<SectionEntry*>(bytes.data() + sizeof(FileHeader));
    const uint32_t count = header().section_count;
    for (uint32_t i = 0; i < count; ++i) {
      SectionEntry& e = table[i];
      if (e.offset > bytes.size() || e.stored_size > bytes.size() - e.offset) continue;
      e.stored_xxh3 = XXH3_64bits(bytes.data() + e.offset, e.stored_size);
      if (e.storage == 0) e.logical_xxh3 = e.stored_xxh3;
    }
    header().section_table_xxh3 = XXH3_64bits(table, count * sizeof(SectionEntry));
    header().header_xxh3 = XXH3_64bits(bytes.data(), 56);
  }
};

class Contents : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const BakedObject one = must_bake(leaves(4), quick(2)), two = must_bake(cube(), quick(3));
    ASSERT_GE(one.record.brick_count, 5u);  // the tests below damage bricks 3 and 4
    small_ = new Buffer(sidecar_bytes({&one}));
    BakeOptions with_geometry = quick(3);
    with_geometry.embed_geometry = true;
    const BakedObject three = must_bake(sphere(6, 8), with_geometry);
    several_ = new Buffer(sidecar_bytes({&one, &two, &three}));
    shipped_ = new Buffer(sidecar_bytes({&one, &two, &three}, Storage::zstd));
    BakeOptions horizons;
    horizons.method = Method::none, horizons.horizons = true;
    const BakedObject four = must_bake(sphere(6, 8), horizons);
    self_ = new Buffer(sidecar_bytes({&four}));
    shipped_self_ = new Buffer(sidecar_bytes({&four}, Storage::zstd));
  }
  static void TearDownTestSuite() {
    delete small_;
    delete several_;
    delete shipped_;
    delete self_;
    delete shipped_self_;
  }
  static inline Buffer *small_, *several_, *shipped_;
  static inline Buffer *self_, *shipped_self_;  // with horizons
};

TEST_F(Contents, AcceptsWhatTheWriterWrites) {
  for (const Buffer* file : {small_, several_, shipped_, self_, shipped_self_})
    for (CheckLevel level : kLevels) {
      const auto findings = findings_of(*file, level);
      EXPECT_TRUE(findings.empty()) << describe(findings[0]);
    }
}

TEST_F(Contents, RefusesEveryPrefix) {
  for (const Buffer* file : {small_, shipped_})
    for (size_t size = 0; size < file->size(); ++size)
      for (CheckLevel level : kLevels) ASSERT_TRUE(has_error(findings_of(Bytes(*file).first(size), level))) << size;
  // Of the larger file, the ends of everything.
  for (size_t size = 0; size < several_->size(); size += size < 8192 || size % 4096 < 2 ? 1 : 61)
    ASSERT_TRUE(has_error(findings_of(Bytes(*several_).first(size)))) << size;
}

TEST_F(Contents, RefusesOneByteMore) {
  Buffer longer = *small_;
  longer.push_back(std::byte{0});
  EXPECT_TRUE(found(findings_of(longer), FindingId::file_size));
}

TEST_F(Contents, RefusesEveryFlippedBit) {
  for (const Buffer* file : {small_, shipped_}) {
    Buffer copy = *file;
    for (size_t bit = 0; bit < copy.size() * 8; ++bit) {
      copy[bit / 8] ^= std::byte{1} << (bit % 8);
      ASSERT_TRUE(has_error(findings_of(copy))) << "bit " << bit;
      copy[bit / 8] ^= std::byte{1} << (bit % 8);
      if (bit % 8 == 7 && bit / 8 > 1200 && bit / 8 + 40 < copy.size()) bit += 8 * 32;  // inside trees, one byte in 33
    }
  }
}

TEST_F(Contents, SurvivesEveryFlippedBitOfSealedTables) {
  // Checksums that fit again: what is behind them must be safe, if not always noticed (a name's letter, say).
  for (const Buffer* file : {small_, shipped_}) {
    const size_t tables = 64 + 64 * 10 + 3 * 256;
    for (size_t bit = 64 * 8; bit < std::min(tables, file->size()) * 8; ++bit) {
      FileToDamage copy{*file};
      copy.bytes[bit / 8] ^= std::byte{1} << (bit % 8);
      copy.seal();
      for (CheckLevel level : kLevels) findings_of(copy.bytes, level);
    }
  }
}

// Makes the object one of another method; its tree stays.
void set_method(ObjectRecord& r, Method method) {
  r.method = static_cast<uint8_t>(method);
  std::fill_n(r.method_parameters, 8, 0);
  if (method == Method::sampled || method == Method::hybrid) r.method_parameters[0] = 81;
  r.guard_band = method == Method::proven || method == Method::hybrid ? 0.01f : 0.0f;
}

void set_audit(ObjectRecord& r, std::array<uint64_t, 2> lines, std::array<uint64_t, 2> wrong, float bound) {
  std::copy_n(lines.begin(), 2, r.audit_lines);
  std::copy_n(wrong.begin(), 2, r.audit_wrong);
  r.audit_bound_95 = bound;
}

struct Damage {
  FindingId expected;
  std::function<void(FileToDamage&)> apply;
  bool seal = true;
  const Buffer* of = nullptr;  // else small_
};

TEST_F(Contents, EveryFindingIsFound) {
  const std::vector<Damage> damages = {
      {FindingId::file_too_short, [](FileToDamage& f) { f.bytes.resize(63); }, false},
      {FindingId::bad_magic,
       [](FileToDamage& f) {
         f.header().magic = {'P', 'K', 3, 4};
       },
       false},
      {FindingId::transfer_damage, [](FileToDamage& f) { f.header().magic[4] = '\n'; }, false},
      {FindingId::unsupported_version, [](FileToDamage& f) { f.header().version_major = 9; }},
      {FindingId::header_checksum, [](FileToDamage& f) { f.header().section_count ^= 1; }, false},
      {FindingId::reserved_not_zero, [](FileToDamage& f) { f.header().reserved[5] = 1; }},
      {FindingId::file_size, [](FileToDamage& f) { f.bytes.push_back({}); }},
      {FindingId::section_table_range,
       [](FileToDamage& f) {
         f.header().section_count = 0xFFFFFFFF;
         f.header().header_xxh3 = XXH3_64bits(f.bytes.data(), 56);
       },
       false},
      {FindingId::section_table_checksum, [](FileToDamage& f) { f.section(kSectionTree).offset ^= 1; }, false},
      {FindingId::unknown_critical, [](FileToDamage& f) { f.section(kSectionTree).type = section_type("WHAT"); }},
      {FindingId::section_flags, [](FileToDamage& f) { f.section(kSectionTree).flags = 0; }},
      {FindingId::section_storage, [](FileToDamage& f) { f.section(kSectionNames).storage = 1; }},
      {FindingId::section_alignment, [](FileToDamage& f) { f.section(kSectionTree).alignment = 512; }},
      {FindingId::section_range, [](FileToDamage& f) { f.section(kSectionTree).offset += 4096; }},
      {FindingId::section_size, [](FileToDamage& f) { f.section(kSectionTree).logical_size += 1; }},
      {FindingId::section_object, [](FileToDamage& f) { f.section(kSectionTree).object = kNone; }},
      {FindingId::section_count, [](FileToDamage& f) { f.section(kSectionProvenance).type = kSectionNames; }},
      {FindingId::padding_not_zero,
       [](FileToDamage& f) { f.bytes[f.section(kSectionTree).offset - 1] = std::byte{1}; }},
      {FindingId::trailing_bytes,
       [](FileToDamage& f) {
         f.bytes.resize(f.bytes.size() + 8);
         f.header().file_size += 8;
       }},
      {FindingId::stored_checksum, [](FileToDamage& f) { f.brick(3)[0] ^= 1; }, false},
      {FindingId::object_name, [](FileToDamage& f) { f.bytes[f.section(kSectionNames).offset] = std::byte{0xFF}; }},
      {FindingId::object_depth, [](FileToDamage& f) { f.object().depth = 9; }},
      {FindingId::object_method, [](FileToDamage& f) { f.object().method_parameters[0] = 17; }},
      {FindingId::object_audit, [](FileToDamage& f) { f.object().audit_wrong[1] = 1; }},
      {FindingId::object_box, [](FileToDamage& f) { f.object().box_max[1] = f.object().box_min[1]; }},
      {FindingId::zstd_frame,
       [](FileToDamage& f) {  // a skippable frame, which is a frame of no bytes to whoever decompresses it
         SectionEntry& e = f.section(kSectionProvenance);
         e.type = section_type("NEWS"), e.storage = static_cast<uint32_t>(Storage::zstd);
         e.logical_size = 0, e.logical_xxh3 = XXH3_64bits(nullptr, 0);
         const uint32_t frame[] = {ZSTD_MAGIC_SKIPPABLE_START, static_cast<uint32_t>(e.stored_size - 8)};
         std::memcpy(f.bytes.data() + e.offset, frame, sizeof frame);
       }},
      {FindingId::object_shift, [](FileToDamage& f) { f.object().shift[1] = std::numeric_limits<double>::infinity(); }},
      {FindingId::object_section, [](FileToDamage& f) { f.object().tree_section = 77; }},
      {FindingId::object_counts, [](FileToDamage& f) { f.object().brick_count += 1; }},
      {FindingId::object_statistics, [](FileToDamage& f) { f.object().nodes_folded += 1; }},
      {FindingId::names_slack, [](FileToDamage& f) { f.object().name_length -= 1; }},
      {FindingId::tree_uniform, [](FileToDamage& f) { f.brick(1)[7] = 0; }},
      {FindingId::tree_index, [](FileToDamage& f) { f.tree()[3] = 0xFFFFFFF0; }},
      {FindingId::tree_spare, [](FileToDamage& f) { f.tree()[15] = 1; }},
      {FindingId::tree_class, [](FileToDamage& f) { f.brick(3)[0] |= 3; }},
      {FindingId::tree_unreferenced, [](FileToDamage& f) { std::fill_n(f.tree(), 15, 0); }},
      {FindingId::tree_duplicate, [](FileToDamage& f) { std::copy_n(f.brick(3), 64, f.brick(4)); }},
      {FindingId::hierarchy_size, [](FileToDamage& f) { f.hierarchy_header().node_count += 1; }},
      {FindingId::hierarchy_order, [](FileToDamage& f) { f.hierarchy_root().child[0] += 1; }},
      {FindingId::hierarchy_leaf, [](FileToDamage& f) { f.hierarchy_leaf().corner[2][15] = 1; }},
      {FindingId::hierarchy_box, [](FileToDamage& f) { f.hierarchy_root().min[1][0] = -1; }},
      {FindingId::horizon_size, [](FileToDamage& f) { f.horizon().entries -= 1; }, true, self_},
      {FindingId::horizon_slopes, [](FileToDamage& f) { f.horizon().slope[2][14] = 0; }, true, self_},
      {FindingId::horizon_place, [](FileToDamage& f) { f.horizon_entry(9).place += 1; }, true, self_},
      {FindingId::provenance, [](FileToDamage& f) { f.bytes[f.section(kSectionProvenance).offset] = std::byte{3}; }},
  };
  std::set<FindingId> seen;
  for (const Damage& damage : damages) {
    FileToDamage file{damage.of ? *damage.of : *small_};
    damage.apply(file);
    if (damage.seal) file.seal();
    if (const char* folder = std::getenv("VCD_WRITE_INVALID"))  // how tests/golden/invalid came to be
      write_file(std::filesystem::path(folder) / (std::string(finding_info(damage.expected).id) + ".vcd"), file.bytes);
    const auto findings = findings_of(file.bytes);
    EXPECT_TRUE(found(findings, damage.expected))
        << finding_info(damage.expected).id << (findings.empty() ? "" : ", but: " + describe(findings[0]));
    seen.insert(damage.expected);
  }
  // Two that only compressed sections can have; tree-depth has a test of its own.
  FileToDamage broken{*shipped_};
  broken.bytes[broken.section(kSectionTree).offset + broken.section(kSectionTree).stored_size - 2] ^= std::byte{0xFF};
  broken.seal();
  const auto findings = findings_of(broken.bytes);
  EXPECT_TRUE(found(findings, FindingId::decompression) || found(findings, FindingId::logical_checksum));
  FileToDamage lying{*shipped_};
  lying.section(kSectionTree).logical_xxh3 ^= 1;
  lying.header().section_table_xxh3 =
      XXH3_64bits(lying.bytes.data() + 64, lying.header().section_count * sizeof(SectionEntry));
  lying.header().header_xxh3 = XXH3_64bits(lying.bytes.data(), 56);
  EXPECT_TRUE(found(findings_of(lying.bytes), FindingId::logical_checksum));
  EXPECT_EQ(seen.size() + 3, all_findings().size()) << "a finding of the table has no test";
}

TEST_F(Contents, HorizonsAreHeldToTheirRules) {
  const auto finding_of = [](const Buffer* file, CheckLevel level, const std::function<void(FileToDamage&)>& change) {
    FileToDamage damaged{*file};
    change(damaged);
    damaged.seal();
    const auto findings = findings_of(damaged.bytes, level);
    return findings.empty() ? std::string() : std::string(finding_info(findings[0].id).id);
  };
  const auto canonical = [&](const std::function<void(FileToDamage&)>& change) {
    return finding_of(self_, CheckLevel::canonical, change);
  };
  const auto bounds = [&](const std::function<void(FileToDamage&)>& change) {
    return finding_of(self_, CheckLevel::bounds, change);
  };
  EXPECT_EQ(bounds([](FileToDamage& f) { f.horizon().reserved = 1; }), "horizon-size");
  EXPECT_EQ(bounds([](FileToDamage& f) { f.horizon().padding[9] = 1; }), "horizon-size");
  EXPECT_EQ(bounds([](FileToDamage& f) { f.horizon().cosine = 1.5f; }), "horizon-size");
  EXPECT_EQ(bounds([](FileToDamage& f) { f.horizon().uniform = std::numeric_limits<float>::quiet_NaN(); }),
            "horizon-size");
  EXPECT_EQ(bounds([](FileToDamage& f) { f.horizon().slope[0][0] = 0; }), "horizon-slopes");
  EXPECT_EQ(bounds([](FileToDamage& f) { f.horizon().slope[3][15] = 16; }), "horizon-slopes");
  EXPECT_EQ(bounds([](FileToDamage& f) { f.horizon().slope[3][14] = 17; }), "horizon-slopes");
  // What leads out of the hierarchy is found at once, what names no triangle in it by the canonical check.
  EXPECT_EQ(bounds([](FileToDamage& f) { f.horizon_entry(3).place |= kPlaceUnitMask; }), "horizon-place");
  EXPECT_EQ(bounds([](FileToDamage& f) { f.horizon_entry(3).place = f.hierarchy_header().units - 3; }),
            "horizon-place");
  EXPECT_EQ(bounds([](FileToDamage& f) { f.horizon_entry(3).place = 0; }), "");
  EXPECT_EQ(canonical([](FileToDamage& f) { f.horizon_entry(3).place = 0; }), "horizon-place");
  EXPECT_EQ(canonical([](FileToDamage& f) { f.horizon_entry(3).place |= 15u << kPlaceTriangleShift; }),
            "horizon-place");
  EXPECT_EQ(canonical([](FileToDamage& f) {
              f.horizon_entry(3).place = 0;
              std::ranges::fill(f.horizon_entry(3).codes, uint8_t{0xFF});
            }),
            "");
  EXPECT_EQ(canonical([](FileToDamage& f) { f.section(kSectionHierarchy).type = section_type("NEWS"); }),
            "horizon-size");
  EXPECT_EQ(canonical([](FileToDamage& f) { f.section(kSectionHorizon).object = kNone; }), "section-object");
  EXPECT_EQ(canonical([](FileToDamage& f) { f.section(kSectionHorizon).object = 1; }), "section-object");
  EXPECT_EQ(canonical([](FileToDamage& f) { f.section(kSectionHorizon).flags = 1; }), "section-flags");
  EXPECT_EQ(canonical([](FileToDamage& f) { f.section(kSectionHorizon).alignment = 8; }), "section-alignment");
  Buffer second(*self_);
  SidecarToWrite twice;
  std::vector<Finding> none;
  const auto contents = read_sidecar(second, CheckLevel::canonical, none);
  ASSERT_TRUE(contents);
  const ObjectContents& object = contents->objects[0];
  twice.objects = {{object.name, *object.record, {}, {}, object.hierarchy.bytes(), {}, object.horizon.all_bytes()}};
  OptionalSection again;
  again.entry.type = kSectionHorizon, again.entry.object = 0, again.entry.alignment = kUnitAlignment;
  again.logical = object.horizon.all_bytes();
  twice.others = {again};
  const auto written = vcd::sidecar_bytes(twice);
  ASSERT_TRUE(written);
  EXPECT_TRUE(found(findings_of({written->data.get(), written->size}), FindingId::section_count));
}

TEST_F(Contents, WhatIsWrongInsideACompressedTreeIsFoundInTheFile) {
  std::vector<Finding> none;
  const auto contents = read_sidecar(*small_, CheckLevel::canonical, none);
  ASSERT_TRUE(contents.has_value());
  const ObjectContents& object = contents->objects[0];
  Buffer tree;
  for (const Bytes piece : tree_pieces(object.tree)) tree.insert(tree.end(), piece.begin(), piece.end());
  tree[object.tree.shape.top_words() * 4] = std::byte{1};
  SidecarToWrite damaged;
  damaged.storage = Storage::zstd;
  damaged.objects = {{object.name, *object.record, {tree}, {}}};
  const auto written = vcd::sidecar_bytes(damaged);
  ASSERT_TRUE(written);
  const FileToDamage file{Buffer(written->data.get(), written->data.get() + written->size)};
  const auto findings = findings_of(file.bytes);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].id, FindingId::tree_spare);
  EXPECT_EQ(findings[0].offset, FileToDamage(file).section(kSectionTree).offset);
}

// What a record may say of its method, guard band and audit, and what it may not.
TEST_F(Contents, TheRecordIsHeldToItsRules) {
  const auto first_finding = [](const std::function<void(ObjectRecord&)>& change) -> std::string {
    FileToDamage file{*small_};
    change(file.object());
    file.seal();
    const auto findings = findings_of(file.bytes);
    return findings.empty() ? "" : finding_info(findings[0].id).id;
  };
  for (Method method : {Method::sampled, Method::proven, Method::hybrid})
    for (uint32_t samples : {0u, 16u, 80u, 81u, 256u}) {
      const bool known = method == Method::proven
                             ? samples == 0
                             : samples == 81 || samples == 256 || (samples == 16 && method == Method::sampled);
      EXPECT_EQ(first_finding([&](ObjectRecord& r) { set_method(r, method), r.method_parameters[0] = samples; }),
                known ? "" : "object-method")
          << static_cast<int>(method) << " " << samples;
      EXPECT_EQ(first_finding([&](ObjectRecord& r) { set_method(r, method), r.method_parameters[7] = 1; }),
                "object-method");
    }
  EXPECT_EQ(first_finding([](ObjectRecord& r) { r.method = 4; }), "object-method");
  EXPECT_EQ(first_finding([](ObjectRecord& r) { set_method(r, Method::none), r.method_parameters[1] = 1; }),
            "object-method");

  for (Method method : {Method::sampled, Method::proven, Method::hybrid})
    for (float guard : {0.0f, 1e-6f, 3.0f, -0.01f, kInfinity, kNaN}) {
      const bool fits = method == Method::sampled ? guard == 0 : guard == 1e-6f || guard == 3;
      EXPECT_EQ(first_finding([&](ObjectRecord& r) { set_method(r, method), r.guard_band = guard; }),
                fits ? "" : "object-method")
          << static_cast<int>(method) << " " << guard;
    }

  using Two = std::array<uint64_t, 2>;
  struct Audit {
    Two lines, wrong;
    float bound;
    bool fits;
  };
  for (const Audit& a : {Audit{{0, 0}, {0, 0}, 0, true},
                         {{0, 0}, {0, 0}, 1, false},
                         {{0, 0}, {1, 0}, 0, false},
                         {{0, 9}, {0, 9}, 0, true},
                         {{0, 9}, {0, 10}, 0, false},
                         {{100, 0}, {1, 0}, 0.05f, true},
                         {{100, 0}, {1, 0}, 0.009f, false},
                         {{100, 0}, {1, 0}, 1.01f, false},
                         {{100, 0}, {101, 0}, 1, false},
                         {{100, 0}, {100, 0}, 1, true},
                         {{100, 0}, {1, 0}, kNaN, false},
                         {{100, 0}, {1, 0}, kInfinity, false}})
    for (Method method : {Method::sampled, Method::hybrid})
      EXPECT_EQ(first_finding([&](ObjectRecord& r) { set_method(r, method), set_audit(r, a.lines, a.wrong, a.bound); }),
                a.fits ? "" : "object-audit")
          << a.lines[0] << " " << a.wrong[0] << " " << a.bound;
  EXPECT_EQ(first_finding([](ObjectRecord& r) {
              set_method(r, Method::proven), set_audit(r, {100, 100}, {}, 0.03f);
            }),
            "");
  for (const Two& wrong : {Two{1, 0}, Two{0, 1}})
    EXPECT_EQ(first_finding([&](ObjectRecord& r) {
                set_method(r, Method::proven), set_audit(r, {100, 100}, wrong, 0.1f);
              }),
              "object-audit");

  // Statistical cells: of hybrids only, as many as there are.
  const auto move_cell = [](ObjectRecord& r) { --r.cells[2], ++r.statistical_cells; };
  EXPECT_EQ(first_finding(move_cell), "object-counts");
  EXPECT_EQ(first_finding([&](ObjectRecord& r) { set_method(r, Method::proven), move_cell(r); }), "object-counts");
  EXPECT_EQ(first_finding([&](ObjectRecord& r) { set_method(r, Method::hybrid), move_cell(r); }), "object-statistics");
  EXPECT_EQ(first_finding([&](ObjectRecord& r) { set_method(r, Method::hybrid), ++r.statistical_cells; }),
            "object-counts");
  EXPECT_EQ(first_finding([&](ObjectRecord& r) {
              set_method(r, Method::hybrid), r.cells[0] -= r.statistical_cells = ~uint64_t{0};
            }),
            "object-counts");
  EXPECT_EQ(first_finding([](ObjectRecord& r) { r.flags = 128; }), "reserved-not-zero");
  EXPECT_EQ(first_finding([](ObjectRecord& r) { r.flags = known_object_flags(kVersionMinor); }), "");
  for (double shift : {double{kInfinity}, double{kNaN}})
    EXPECT_EQ(first_finding([&](ObjectRecord& r) { r.shift[2] = shift; }), "object-shift");
  EXPECT_EQ(first_finding([](ObjectRecord& r) { r.shift[0] = -4e6, r.shift[2] = 1e300; }), "");
}

Buffer golden(const std::string& name) { return read_file(std::filesystem::path(VCD_GOLDEN_DIR) / name); }

TEST(Class3, IsForHybridsOnly) {
  for (const char* name : {"depth1.vcd", "depth2.vcd"}) {
    const FileToDamage hybrid{golden(name)};
    EXPECT_TRUE(findings_of(hybrid.bytes).empty()) << name;
    for (Method method : {Method::sampled, Method::proven}) {
      FileToDamage other = hybrid;
      set_method(other.object(), method);
      set_audit(other.object(), {}, {}, 0);
      // Bricks are not read at bounds level, so this could be.
      other.object().cells[2] += other.object().statistical_cells;
      other.object().statistical_cells = 0;
      other.seal();
      EXPECT_TRUE(found(findings_of(other.bytes), FindingId::tree_class)) << name;
      std::vector<Finding> none;
      const auto contents = read_sidecar(other.bytes, CheckLevel::bounds, none);
      ASSERT_TRUE(contents.has_value());
      const Place pierces = Place::pierces;
      EXPECT_EQ(contents->objects[0].tree.answers(pierces, CellClass::statistically_blocked), Visibility::unclassified);
    }
  }
}

TEST(Class3, IsBlockedForHybridsAndForSegmentsThatPierceOnly) {
  // Every answer of classify() against the bits of the segment's cell.
  const Buffer file = golden("depth2.vcd");
  std::vector<Finding> none;
  const auto contents = read_sidecar(file, CheckLevel::canonical, none);
  ASSERT_TRUE(contents.has_value());
  const ObjectContents& object = contents->objects[0];
  TreeView proven = object.tree;
  proven.answers = answer_table(Trust::proofs);
  const GridFrame frame = make_grid_frame(object.record->box_min, object.record->box_max);
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(-0.5f, 1.5f);
  std::array<int, kClasses> seen{};
  for (int i = 0; i < 20000; ++i) {
    Segment segment{{}, 0, {}, 1};
    for (int a = 0; a < 3; ++a) {
      const float extent = object.record->box_max[a] - object.record->box_min[a];
      segment.origin[a] = object.record->box_min[a] + extent * uniform(random);
      segment.direction[a] = extent * uniform(random);
    }
    const LineCell line = locate(frame, segment);
    if (!line.valid || !line.hits || line.t_entry >= 1 || line.t_exit <= 0) continue;
    const auto bits = static_cast<uint32_t>(class_of(object.tree, line));
    const bool pierces = line.t_entry >= 0 && line.t_exit <= 1;
    seen[bits] += pierces;
    const auto expected = [&](bool hybrid) {
      if (bits == 0) return Visibility::clear;
      return pierces && (bits == 1 || (bits == 3 && hybrid)) ? Visibility::blocked : Visibility::unclassified;
    };
    ASSERT_EQ(classify(frame, object.tree, object.tree.shape, segment), expected(true)) << bits << pierces;
    ASSERT_EQ(classify(frame, proven, proven.shape, segment), expected(false)) << bits << pierces;
  }
  for (int count : seen) EXPECT_GT(count, 100);
}

// An object of method none takes a record and a name, beside its hierarchy: no tree, no page.
TEST(NoMethod, HasNoTreeInTheFileAndAllCellsUnclassified) {
  BakeOptions options;
  options.hierarchy = false;
  options.method = Method::none;
  const BakedObject one = must_bake(cube(), options);
  SidecarToWrite out;
  const uint64_t before = sidecar_bytes(out)->size;
  for (int i = 0; i < 250; ++i) out.objects.push_back(one.to_write());
  for (Storage storage : {Storage::raw, Storage::zstd}) {
    out.storage = storage;
    const auto bytes = sidecar_bytes(out);
    ASSERT_TRUE(bytes.ok());
    EXPECT_LE(bytes->size, before + 250 * 300);
    const Bytes file{bytes->data.get(), bytes->size};
    for (CheckLevel level : kLevels) EXPECT_TRUE(findings_of(file, level).empty());
    std::vector<Finding> none;
    const auto contents = read_sidecar(file, CheckLevel::bounds, none);
    const ObjectContents& object = contents->objects[249];
    EXPECT_EQ(object.record->tree_section, kNone);
    for (uint32_t pair = 0; pair < kFacePairs; ++pair) {
      LineCell line{};
      line.pair = pair, line.s = 255, line.v = 17;
      EXPECT_EQ(class_of(object.tree, line), CellClass::unclassified);
    }
  }
}

TEST(NoMethod, IsHeldToItsRules) {
  BakeOptions options;
  options.method = Method::none;
  const BakedObject one = must_bake(cube(), options), two = must_bake(cube(), quick(2));
  const FileToDamage original{sidecar_bytes(std::vector{&one, &two})};
  EXPECT_TRUE(findings_of(original.bytes).empty());
  const auto finds = [&](FindingId id, CheckLevel level, const std::function<void(ObjectRecord&)>& change) {
    FileToDamage file = original;
    change(file.object());
    file.seal();
    return found(findings_of(file.bytes, level), id);
  };
  for (CheckLevel level : kLevels) {
    EXPECT_TRUE(finds(FindingId::object_method, level, [](ObjectRecord& r) { r.depth = 2; }));
    EXPECT_TRUE(finds(FindingId::object_counts, level, [](ObjectRecord& r) { ++r.brick_count; }));
    EXPECT_TRUE(finds(FindingId::object_counts, level, [](ObjectRecord& r) { --r.cells[2], ++r.cells[0]; }));
    EXPECT_TRUE(finds(FindingId::object_section, level, [](ObjectRecord& r) { r.tree_section = 3; }));
  }
  EXPECT_TRUE(finds(FindingId::object_statistics, CheckLevel::canonical, [](ObjectRecord& r) { ++r.nodes_shared; }));
  // A tree that is there all the same is nobody's; an object of another method has one.
  FileToDamage file = original;
  file.section(kSectionTree).object = 0;
  file.seal();
  EXPECT_FALSE(findings_of(file.bytes, CheckLevel::bounds).empty());
  file = original;
  file.object(1).tree_section = kNone;
  file.seal();
  EXPECT_TRUE(found(findings_of(file.bytes, CheckLevel::bounds), FindingId::object_section));
}

// Depth 6 has one level of blocks, 7 two, 8 three.
TEST_F(Contents, RefusesBlocksThatLeaveTheirPool) {
  for (const char* name : {"depth6.vcd", "depth7.vcd", "depth8.vcd"}) {
    const Buffer file = read_file(std::filesystem::path(VCD_GOLDEN_DIR) / name);
    std::vector<Finding> none;
    const auto contents = read_sidecar(file, CheckLevel::canonical, none);
    ASSERT_TRUE(contents.has_value()) << name;
    const TreeView& good = contents->objects[0].tree;
    const auto findings_with = [&](uint64_t word, uint32_t value, CheckLevel level) {
      std::vector<uint32_t> tree;
      for (Bytes piece : tree_pieces(good)) {
        const auto* words = reinterpret_cast<const uint32_t*>(piece.data());
        tree.insert(tree.end(), words, words + piece.size() / 4);
      }
      tree[word] = value;
      SidecarToWrite damaged;
      damaged.objects.push_back({"damaged", *contents->objects[0].record, {std::as_bytes(std::span(tree))}, {}});
      const auto bytes = vcd::sidecar_bytes(damaged);
      return findings_of(Buffer(bytes->data.get(), bytes->data.get() + bytes->size), level);
    };
    for (CheckLevel level : kLevels) {
      uint64_t first = good.shape.top_bytes() / 4;
      for (uint32_t k = 0; k < good.shape.block_levels; first += good.block_counts[k++] * kBlockWords) {
        const uint32_t below = k + 1 < good.shape.block_levels ? good.block_counts[k + 1] : good.brick_count;
        EXPECT_TRUE(found(findings_with(first + 3 * kBlockWords + 5, below, level), FindingId::tree_index)) << k;
        EXPECT_TRUE(found(findings_with(first + kBlockWords, 2, level), FindingId::tree_uniform)) << k;
      }
    }
  }
}

TEST_F(Contents, RefusesBytesAfterAZstdFrame) {
  // An empty second frame in the padding's place: the section grows by it, and everything else is sealed to fit.
  FileToDamage file{*shipped_};
  SectionEntry& e = file.section(kSectionGeometry);  // the last section
  const uint8_t empty[] = {0x28, 0xB5, 0x2F, 0xFD, 0x20, 0x00, 0x01, 0x00, 0x00};
  Buffer frame(ZSTD_compressBound(64));
  const std::string text(64, 'x');
  frame.resize(ZSTD_compress(frame.data(), frame.size(), text.data(), text.size(), 1));
  for (bool trailing : {false, true}) {
    FileToDamage copy = file;
    Buffer stored = frame;
    if (trailing)
      stored.insert(stored.end(), reinterpret_cast<const std::byte*>(empty),
                    reinterpret_cast<const std::byte*>(empty) + sizeof empty);
    copy.bytes.resize(e.offset);
    copy.bytes.insert(copy.bytes.end(), stored.begin(), stored.end());
    SectionEntry& moved = copy.section(kSectionGeometry);
    moved.type = section_type("NEWS");
    moved.object = kNone;
    moved.storage = 1;
    moved.stored_size = stored.size();
    moved.logical_size = text.size();
    moved.logical_xxh3 = XXH3_64bits(text.data(), text.size());
    copy.object(2).geometry_section = kNone;
    copy.header().file_size = copy.bytes.size();
    copy.seal();
    const auto findings = findings_of(copy.bytes);
    EXPECT_EQ(found(findings, FindingId::zstd_frame), trailing) << (findings.empty() ? "" : describe(findings[0]));
    EXPECT_EQ(findings.empty(), !trailing);
    // The content of an unknown compressed section is checked too.
    copy.section(section_type("NEWS")).logical_xxh3 ^= 1;
    copy.header().section_table_xxh3 =
        XXH3_64bits(copy.bytes.data() + 64, copy.header().section_count * sizeof(SectionEntry));
    copy.header().header_xxh3 = XXH3_64bits(copy.bytes.data(), 56);
    EXPECT_FALSE(findings_of(copy.bytes, CheckLevel::checksums).empty());
  }
}

TEST(Clearance, IsOneSectionOfOneSizeForAnObject) {
  const BakedObject baked = must_bake(sphere(), quick(2));
  const auto findings = [&](const SidecarToWrite& contents) {
    const auto bytes = sidecar_bytes(contents);
    std::vector<Finding> found;
    const auto read = read_sidecar({bytes->data.get(), bytes->size}, CheckLevel::canonical, found);
    EXPECT_EQ(read.has_value(), found.empty());
    if (read) {
      EXPECT_EQ(read->objects[0].clearance.size(), kClearanceBytes);
    }
    return found;
  };
  SidecarToWrite good;
  good.objects = {baked.to_write()};
  ASSERT_EQ(good.objects[0].clearance.size(), kClearanceBytes);
  EXPECT_TRUE(findings(good).empty());
  SidecarToWrite bad = good;
  bad.objects[0].clearance = bad.objects[0].clearance.first(8);
  EXPECT_EQ(sidecar_bytes(bad).error().code, ErrorCode::usage);
  bad.objects[0].clearance = {};
  OptionalSection small;
  small.entry.type = kSectionClearance, small.entry.object = 0;
  small.logical = good.objects[0].clearance.first(8);
  bad.others = {small};
  EXPECT_TRUE(found(findings(bad), FindingId::section_size));
  for (const auto& [object, finding] :
       {std::pair(0u, FindingId::section_count), std::pair(1u, FindingId::section_object),
        std::pair(kNone, FindingId::section_object)}) {
    bad = good;
    OptionalSection second;
    second.entry.type = kSectionClearance, second.entry.object = object;
    second.logical = good.objects[0].clearance;
    bad.others = {second};
    EXPECT_TRUE(found(findings(bad), finding)) << object;
  }
}

TEST_F(Contents, RefusesUnequalCellsInATreeOfDepthOne) {
  FileToDamage file{*small_};
  file.object().depth = 1;
  file.seal();
  EXPECT_TRUE(found(findings_of(file.bytes), FindingId::tree_depth));
}

TEST_F(Contents, RefusesAZstdBomb) {
  // A frame that says it holds 64 GiB, and a section entry that agrees.
  FileToDamage file{*shipped_};
  SectionEntry& e = file.section(kSectionTree);
  const uint64_t size = uint64_t{64} << 30;
  const uint8_t frame[] = {0x28, 0xB5, 0x2F, 0xFD, 0xE0};  // single segment, eight bytes of content size
  std::memcpy(file.bytes.data() + e.offset, frame, sizeof frame);
  std::memcpy(file.bytes.data() + e.offset + sizeof frame, &size, sizeof size);
  e.logical_size = size;
  file.seal();
  EXPECT_TRUE(found(findings_of(file.bytes), FindingId::section_size));
}

TEST(ZstdBudget, HoldsForAllSectionsOfAFileTogether) {
  // A hundred sections that claim a mebibyte each: each is allowed, all of them are not.
  const Buffer zeros(size_t{1} << 20);
  Buffer frame(ZSTD_compressBound(zeros.size()));
  frame.resize(ZSTD_compress(frame.data(), frame.size(), zeros.data(), zeros.size(), 19));
  for (uint32_t count : {60u, 100u}) {
    FileToDamage file;
    std::vector<SectionEntry> table(2 + count);
    uint64_t end = sizeof(FileHeader) + table.size() * sizeof(SectionEntry);
    for (uint32_t i = 0; i < table.size(); ++i) {
      SectionEntry& e = table[i];
      e.type = i == 0 ? kSectionObjects : i == 1 ? kSectionNames : section_type("NEWS");
      e.flags = i < 2 ? kSectionCritical : 0;
      e.object = kNone;
      e.storage = i < 2 ? 0 : 1;
      e.alignment = kSmallAlignment;
      e.offset = (end + 7) / 8 * 8;
      e.stored_size = i < 2 ? 0 : frame.size();
      e.logical_size = i < 2 ? 0 : zeros.size();
      e.logical_xxh3 = XXH3_64bits(zeros.data(), e.logical_size);
      end = e.offset + e.stored_size;
    }
    file.bytes.resize(end);
    std::memcpy(file.bytes.data() + sizeof(FileHeader), table.data(), table.size() * sizeof(SectionEntry));
    for (uint32_t i = 2; i < table.size(); ++i)
      std::copy(frame.begin(), frame.end(), file.bytes.begin() + static_cast<std::ptrdiff_t>(table[i].offset));
    FileHeader& header = file.header();
    header.magic = kMagic;
    header.version_major = kVersionMajor;
    header.section_count = static_cast<uint32_t>(table.size());
    header.file_size = end;
    file.seal();
    const auto findings = findings_of(file.bytes);
    EXPECT_EQ(found(findings, FindingId::section_size), count == 100)
        << (findings.empty() ? "" : describe(findings[0]));
    EXPECT_EQ(findings.empty(), count == 60);
  }
}

TEST_F(Contents, LaterMinorVersionsMayUseReservedFieldsAndNewSections) {
  FileToDamage file{*small_};
  file.header().version_minor = 7;
  file.header().reserved[0] = 1;
  file.object().flags = 0x8000;
  file.section(kSectionProvenance).type = section_type("NEWS");
  file.seal();
  const auto findings = findings_of(file.bytes);
  EXPECT_TRUE(findings.empty()) << describe(findings[0]);
}

TEST_F(Contents, FlagsAreReservedBeforeTheyHaveAMeaning) {
  const std::pair<uint16_t, uint16_t> since[] = {{kLookUpTogetherFromOutside, 1},
                                                 {kLookUpTogetherFromInside, 1},
                                                 {kLookUpOneFromOutside, 2},
                                                 {kLookUpOneFromInside, 2}};
  for (const uint16_t minor : {0, 1, 2})
    for (const auto& [flag, first] : since) {
      FileToDamage file{*small_};
      file.header().version_minor = minor;
      file.object().flags = flag;
      file.seal();
      EXPECT_EQ(found(findings_of(file.bytes), FindingId::reserved_not_zero), minor < first) << minor << " " << flag;
    }
}

// Each level finds what it promises, with those before it silent: damaged cells, and damage that somebody sealed.
TEST_F(Contents, EachLevelFindsMoreThanTheOneBefore) {
  const auto first_to_find = [&](const std::function<void(FileToDamage&)>& damage) -> std::optional<CheckLevel> {
    FileToDamage file{*small_};
    damage(file);
    for (CheckLevel level : kLevels)
      if (!findings_of(file.bytes, level).empty()) return level;
    return std::nullopt;
  };
  EXPECT_EQ(first_to_find([](FileToDamage& f) { f.tree()[3] = 0xFFFFFFF0; }), CheckLevel::bounds);
  EXPECT_EQ(first_to_find([](FileToDamage& f) { f.brick(3)[0] ^= 1; }), CheckLevel::checksums);
  EXPECT_EQ(first_to_find([](FileToDamage& f) { f.bytes[f.section(kSectionProvenance).offset + 12] ^= std::byte{1}; }),
            CheckLevel::checksums);
  EXPECT_EQ(first_to_find([](FileToDamage& f) { f.bytes[f.section(kSectionTree).offset - 1] = std::byte{1}; }),
            CheckLevel::canonical);
  EXPECT_EQ(first_to_find([](FileToDamage& f) { f.brick(3)[0] ^= 1, f.seal(); }), CheckLevel::canonical);
  EXPECT_EQ(first_to_find([](FileToDamage& f) { f.object().nodes_folded += 1, f.seal(); }), CheckLevel::canonical);
  EXPECT_EQ(first_to_find([](FileToDamage& f) { std::copy_n(f.brick(3), 64, f.brick(4)), f.seal(); }),
            CheckLevel::canonical);
  EXPECT_EQ(first_to_find([](FileToDamage&) {}), std::nullopt);

  // The checksum of what a compressed section holds is one of the checksums.
  FileToDamage file{*shipped_};
  file.section(kSectionTree).logical_xxh3 ^= 1;
  file.seal();
  EXPECT_TRUE(findings_of(file.bytes, CheckLevel::bounds).empty());
  EXPECT_TRUE(found(findings_of(file.bytes, CheckLevel::checksums), FindingId::logical_checksum));
}

TEST_F(Contents, StorageDoesNotChangeTheContent) {
  FileToDamage raw{*several_}, zstd{*shipped_};
  ASSERT_EQ(raw.header().section_count, zstd.header().section_count);
  EXPECT_LT(zstd.bytes.size(), raw.bytes.size());
  const auto* a = reinterpret_cast<const SectionEntry*>(raw.bytes.data() + 64);
  const auto* b = reinterpret_cast<const SectionEntry*>(zstd.bytes.data() + 64);
  for (uint32_t i = 0; i < raw.header().section_count; ++i) {
    EXPECT_EQ(a[i].type, b[i].type);
    EXPECT_EQ(a[i].logical_xxh3, b[i].logical_xxh3);
  }
}

TEST_F(Contents, TheWriterGivesTheSameBytesInMemory) {
  std::vector<Finding> none;
  const auto contents = read_sidecar(*several_, CheckLevel::canonical, none);
  for (Storage storage : {Storage::raw, Storage::zstd}) {
    SidecarToWrite out;
    out.storage = storage;
    for (const auto& [key, value] : contents->provenance) out.provenance.emplace(key, value);
    for (const ObjectContents& object : contents->objects)
      out.objects.push_back({object.name, *object.record, tree_pieces(object.tree), object.geometry,
                             object.hierarchy.bytes(), object.clearance, object.horizon.all_bytes()});
    const auto memory = vcd::sidecar_bytes(out);
    ASSERT_TRUE(memory.ok());
    EXPECT_EQ(reinterpret_cast<uintptr_t>(memory->data.get()) % 64, 0u);
    const Bytes bytes(memory->data.get(), memory->size);
    const Buffer& expected = storage == Storage::raw ? *several_ : *shipped_;
    EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), expected.begin(), expected.end()));
    const TemporaryFolder folder;
    const auto written = write_sidecar(folder / "a.vcd", out);
    ASSERT_TRUE(written.ok());
    EXPECT_EQ(*written, expected.size());
    EXPECT_EQ(read_file(folder / "a.vcd"), expected);
    out.stop = [] { return true; };
    EXPECT_FALSE(vcd::sidecar_bytes(out).ok());
    EXPECT_FALSE(write_sidecar(folder / "b.vcd", out).ok());
    EXPECT_FALSE(std::filesystem::exists(folder / "b.vcd"));
  }
}

TEST(Writer, LeavesNothingBehindWhenItFails) {
  const TemporaryFolder folder;
  SidecarToWrite empty;
  EXPECT_FALSE(write_sidecar(folder / "missing" / "a.vcd", empty).ok());
  std::filesystem::create_directories(folder / "taken.vcd" / "inside");
  const auto result = write_sidecar(folder / "taken.vcd", empty);
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::io);
  EXPECT_NE(result.error().message.find("taken.vcd"), std::string::npos);
  size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder.path())) ++files;
  EXPECT_EQ(files, 1u);
}

}  // namespace
}  // namespace vcd::test
