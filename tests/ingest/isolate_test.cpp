#include "ingest/isolate.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <limits>
#include <new>
#include <thread>

#include "ingest/wire.h"
#include "mesh_files.h"
#include "support/files.h"

namespace vcd::baker {
namespace {

using Clock = std::chrono::steady_clock;

const std::filesystem::path kName = "folder/some.obj";

Ingested two_meshes() {
  Ingested in;
  in.meshes.push_back({"Größe", 7, {{0, 0, 0}, {1, 0, -0.0f}, {0, 1, 1e-45f}}, {{0, 1, 2}, {2, 1, 0}}});
  in.meshes.push_back({"", 9, {{5, 5, 5}, {6, 5, 5}, {5, 6, 5}}, {{0, 1, 2}}});
  in.notes = {"one", "", "three"};
  in.sources = {{"some.obj", {1, 2, 3}}, {"../odd \n\xff.bin", {4}}};
  in.placements = {{.mesh = 1}, {.mesh = 0, .transform = {-1, 0, 0, 5, 0, 2, 0, 6, 0, 0, 3, 7}}};
  return in;
}

bool equal(const Ingested& a, const Ingested& b) {
  if (a.meshes.size() != b.meshes.size() || a.notes != b.notes || a.placements != b.placements ||
      a.sources != b.sources)
    return false;
  for (size_t i = 0; i < a.meshes.size(); ++i) {
    const SourceMesh& p = a.meshes[i];
    const SourceMesh& q = b.meshes[i];
    if (p.name != q.name || p.source_index != q.source_index || p.positions != q.positions ||
        p.triangles != q.triangles) {
      return false;
    }
  }
  return true;
}

// What goes wrong in the child must come back as a runtime Error that names the file and holds all `parts`.
void expect_fault(const IngestLimits& limits, const std::function<Result<Ingested>()>& work,
                  const std::vector<std::string>& parts) {
  const Result<Ingested> result = run_isolated(kName, limits, work);
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::runtime);
  EXPECT_TRUE(result.error().message.starts_with(kName.string() + ": ")) << result.error().message;
  for (const std::string& part : parts) {
    EXPECT_NE(result.error().message.find(part), std::string::npos) << part << " in " << result.error().message;
  }
}

size_t open_descriptors() {
  size_t count = 0;
  for (int number = 0; number < 1024; ++number) count += ::fcntl(number, F_GETFD) != -1;
  return count;
}

TEST(Isolate, BringsTheResultBack) {
  const Result<Ingested> result = run_isolated(kName, {}, [] { return Result<Ingested>(two_meshes()); });
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_TRUE(equal(*result, two_meshes()));
}

TEST(Isolate, BringsAnErrorBack) {
  const Result<Ingested> result = run_isolated(kName, {}, [] {
    return Result<Ingested>(Error{ErrorCode::unsupported, "what it said"});
  });
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::unsupported);
  EXPECT_EQ(result.error().message, "what it said");
}

TEST(Isolate, ACrashEndsInItsLastWords) {
  expect_fault({},
               []() -> Result<Ingested> {
                 std::fprintf(stderr, "long ago\nfirst to last\nthe last line\n");
                 ::signal(SIGSEGV, SIG_DFL);
                 ::raise(SIGSEGV);
                 return Ingested();
               },
               {"the parser crashed (SIGSEGV): first to last; the last line"});
  expect_fault({}, []() -> Result<Ingested> { std::abort(); }, {"crashed (SIGABRT)"});
}

TEST(Isolate, AnEarlyExitIsNoResult) {
  expect_fault({}, []() -> Result<Ingested> { ::_exit(3); }, {"exit status 3"});
  expect_fault({}, []() -> Result<Ingested> { ::_exit(0); }, {"without a whole result"});
  expect_fault({},
               []() -> Result<Ingested> {
                 ::kill(::getpid(), SIGKILL);
                 return Ingested();
               },
               {"killed"});
}

TEST(Isolate, ExceptionsAndExhaustedMemory) {
  expect_fault({}, []() -> Result<Ingested> { throw std::bad_alloc(); }, {"out of memory"});
  expect_fault({}, []() -> Result<Ingested> { throw std::runtime_error("odd"); }, {"the parser failed: odd"});
}

TEST(Isolate, AHangIsKilledInTime) {
  const Clock::time_point start = Clock::now();
  expect_fault({0.3, uint64_t{1} << 30},
               []() -> Result<Ingested> {
                 for (;;) {
                   std::fprintf(stderr, "still here\n");  // nor may a flood of words block or fill the caller
                 }
               },
               {"more than 0.3 s", "still here"});
  expect_fault({0.2, uint64_t{1} << 30},
               []() -> Result<Ingested> {
                 for (int number = 0; number < 64; ++number) ::close(number);
                 for (;;) ::pause();
               },
               {"more than 0.2 s"});
  EXPECT_LT(Clock::now() - start, std::chrono::seconds(20));
}

TEST(Isolate, AMemoryFloodIsStopped) {
  if (test::kSanitized) GTEST_SKIP() << "no limit on address space under sanitizers";
  const auto flood = []() -> Result<Ingested> {
    std::vector<std::vector<char>> hoard;
    for (int i = 0; i < 1024; ++i) hoard.emplace_back(size_t{1} << 20, char{1});
    return Ingested();
  };
  expect_fault({30, uint64_t{128} << 20}, flood, {"out of memory"});
}

TEST(Isolate, NothingIsPrinted) {
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  const Result<Ingested> result = run_isolated(kName, {}, [] {
    std::printf("chatter\n");
    std::fflush(stdout);
    std::cerr << "chatter" << std::endl;
    return Result<Ingested>(two_meshes());
  });
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_TRUE(result.ok());
}

TEST(Isolate, LeavesNoDescriptorAndNoZombie) {
  const size_t before = open_descriptors();
  for (int i = 0; i < 3; ++i) {
    (void)run_isolated(kName, {}, [] { return Result<Ingested>(two_meshes()); });
    (void)run_isolated(kName, {}, []() -> Result<Ingested> { std::abort(); });
    (void)run_isolated(kName, {0.05, uint64_t{1} << 30}, []() -> Result<Ingested> {
      for (;;) ::pause();
    });
  }
  EXPECT_EQ(open_descriptors(), before);
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
}

TEST(Isolate, WorksWhileOtherThreadsForkAndAllocate) {
  std::atomic<int> good = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&good] {
      for (int i = 0; i < 8; ++i) {
        const Result<Ingested> result = run_isolated(kName, {20, uint64_t{1} << 30}, [] {
          std::vector<std::string> work(1000, std::string(100, 'x'));
          return Result<Ingested>(two_meshes());
        });
        good += result.ok() && equal(*result, two_meshes());
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(good, 32);
}

TEST(Isolate, TheChildDiesWithItsParent) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const pid_t middle = ::fork();
  if (middle == 0) {
    ::close(ends[0]);
    (void)run_isolated(kName, {}, [&]() -> Result<Ingested> {
      (void)!::write(ends[1], "x", 1);
      for (;;) ::pause();
    });
    ::_exit(0);
  }
  ::close(ends[1]);
  char byte = 0;
  ASSERT_EQ(::read(ends[0], &byte, 1), 1);  // the grandchild is at work
  ::kill(middle, SIGKILL);
  ::waitpid(middle, nullptr, 0);
  ::alarm(20);                              // fail rather than hang
  EXPECT_EQ(::read(ends[0], &byte, 1), 0);  // only once the last writer, the grandchild, is gone
  ::alarm(0);
  ::close(ends[0]);
}

TEST(Isolate, ACorruptResultIsNotBelieved) {
  Ingested broken = two_meshes();
  broken.meshes[1].triangles[0][2] = 3;
  Result<Ingested> result = run_isolated(kName, {}, [&] { return Result<Ingested>(broken); });
  ASSERT_FALSE(result.ok());
  EXPECT_NE(result.error().message.find("mesh 9 \"\": triangle 0: index 3 is out of range"), std::string::npos);
  broken = two_meshes();
  broken.meshes[0].positions[1][1] = std::numeric_limits<float>::quiet_NaN();
  result = run_isolated(kName, {}, [&] { return Result<Ingested>(broken); });
  ASSERT_FALSE(result.ok());
  EXPECT_NE(result.error().message.find("mesh 7 \"Größe\": position 1 is not finite"), std::string::npos);
}

TEST(Isolate, ACorruptPlacementIsNotBelieved) {
  for (const Placement& placement :
       {Placement{.mesh = 2}, Placement{.transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0}},
        Placement{.transform = {1, 0, 0, std::numeric_limits<float>::infinity(), 0, 1, 0, 0, 0, 0, 1, 0}}}) {
    Ingested broken = two_meshes();
    broken.placements[1] = placement;
    expect_fault({}, [&] { return Result<Ingested>(broken); }, {"without a whole result"});
  }
}

class IsolateFiles : public test::MeshFiles {};

TEST_F(IsolateFiles, EqualsIngest) {
  const std::filesystem::path path = write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\np 1\nf 1 2 3\n");
  const Result<Ingested> direct = ingest(path);
  const Result<Ingested> isolated = ingest_isolated(path);
  ASSERT_TRUE(direct.ok() && isolated.ok());
  EXPECT_TRUE(equal(*direct, *isolated));
  const std::filesystem::path bad = write("b.obj", "v 0 0 nan\n");
  EXPECT_EQ(ingest(bad).error().message, ingest_isolated(bad).error().message);
  EXPECT_EQ(ingest_isolated(folder_ / "absent.ply").error().code, ErrorCode::io);
}

TEST_F(IsolateFiles, WireRefusesEveryPrefixAndEverySurplus) {
  const std::filesystem::path path = write("wire", "");
  const auto read_wire = [&](const std::string& bytes) {
    write("wire", bytes);
    const int file = ::open(path.c_str(), O_RDONLY);
    std::optional<Result<Ingested>> result = read_result(file);
    ::close(file);
    return result;
  };
  const int file = ::open(path.c_str(), O_WRONLY);
  ASSERT_TRUE(write_result(file, two_meshes()));
  ::close(file);
  std::ifstream stream(path, std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  ASSERT_TRUE(read_wire(whole).has_value());
  for (size_t size = 0; size < whole.size(); ++size) EXPECT_FALSE(read_wire(whole.substr(0, size)).has_value());
  EXPECT_FALSE(read_wire(whole + "x").has_value());
  for (const size_t offset : {size_t{0}, whole.size() - 1}) {
    std::string changed = whole;
    changed[offset] ^= 1;
    EXPECT_FALSE(read_wire(changed).has_value());
  }
  // Counts that are larger than the file: refused before anything is allocated for them.
  for (size_t offset = 8; offset + 8 <= whole.size(); offset += 1) {
    std::string lying = whole;
    lying.replace(offset, 8, 8, '\x7F');
    (void)read_wire(lying);
  }
}

}  // namespace
}  // namespace vcd::baker
