#include <vcd/writer/atomic_file.h>

#include <gtest/gtest.h>

#include <fstream>
#include <set>

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support/files.h"

namespace vcd {
namespace {

namespace fs = std::filesystem;

Bytes bytes(std::string_view text) { return std::as_bytes(std::span(text)); }

class AtomicFiles : public ::testing::Test {
 protected:
  std::set<std::string> names() const {
    std::set<std::string> found;
    for (const auto& entry : fs::directory_iterator(folder_.path())) found.insert(entry.path().filename().string());
    return found;
  }
  std::string text(const std::string& name) const {
    const auto content = test::read_file(folder_ / name);
    return {reinterpret_cast<const char*>(content.data()), content.size()};
  }
  using Names = std::set<std::string>;
  test::TemporaryFolder folder_;
};

TEST_F(AtomicFiles, AppearsWholeAndReplaces) {
  for (const std::string content : {"one", "two"}) {
    AtomicFile file(folder_ / "x");
    file.append(bytes(content));
    EXPECT_EQ(names().contains("x"), content == "two");
    const auto size = file.commit();
    ASSERT_TRUE(size.ok()) << size.error().message;
    EXPECT_EQ(*size, 3u);
    EXPECT_EQ(text("x"), content);
  }
  EXPECT_EQ(names(), Names{"x"});
}

TEST_F(AtomicFiles, WithoutCommitNothingIsLeft) {
  {
    AtomicFile file(folder_ / "x");
    file.append(bytes("half"));
  }
  EXPECT_EQ(names(), Names{});
}

TEST_F(AtomicFiles, AMappedFileKeepsItsOldBytes) {
  {
    AtomicFile file(folder_ / "x");
    file.append(bytes("old bytes"));
    ASSERT_TRUE(file.commit().ok());
  }
  const int old = open((folder_ / "x").c_str(), O_RDONLY);
  const char* const mapped = static_cast<const char*>(mmap(nullptr, 9, PROT_READ, MAP_PRIVATE, old, 0));
  close(old);
  {
    AtomicFile file(folder_ / "x");
    file.append(bytes("new"));
    ASSERT_TRUE(file.commit().ok());
  }
  EXPECT_EQ(std::string(mapped, 9), "old bytes");
  munmap(const_cast<char*>(mapped), 9);
}

TEST_F(AtomicFiles, WhatDoesNotReadBackIsNotKept) {
  AtomicFile file(folder_ / "x");
  file.append(bytes("abc"));
  std::string seen;
  const auto result = file.commit([&](Bytes back) {
    seen.assign(reinterpret_cast<const char*>(back.data()), back.size());
    return std::string("byte 2 is odd");
  });
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(seen, "abc");
  EXPECT_NE(result.error().message.find("x: what was written does not read back: byte 2 is odd"), std::string::npos)
      << result.error().message;
  EXPECT_EQ(names(), Names{});
}

TEST_F(AtomicFiles, AKilledWriterLeavesNothing) {
  for (const bool replaces : {false, true}) {
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    const pid_t child = fork();
    if (child == 0) {
      AtomicFile file(folder_ / "x");
      file.append(bytes("half"));
      (void)!write(ends[1], "x", 1);
      for (;;) pause();
    }
    char ready;
    ASSERT_EQ(read(ends[0], &ready, 1), 1);
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    close(ends[0]), close(ends[1]);
    EXPECT_EQ(names(), replaces ? Names{"x"} : Names{});
    std::ofstream(folder_ / "x") << "whole";
  }
}

TEST_F(AtomicFiles, StaleTemporariesAreRemovedAndLivingOnesStay) {
  std::ofstream(folder_ / ".vcd-tmp-1") << "of one that was killed";
  std::ofstream(folder_ / "mine") << "x";
  const int living = open((folder_ / ".vcd-tmp-2").c_str(), O_RDWR | O_CREAT, 0666);
  ASSERT_EQ(flock(living, LOCK_EX), 0);
  EXPECT_EQ(remove_stale_temporaries(folder_.path()), 1u);
  EXPECT_EQ(names(), (Names{".vcd-tmp-2", "mine"}));
  close(living);
  EXPECT_EQ(remove_stale_temporaries(folder_.path()), 1u);
  EXPECT_EQ(remove_stale_temporaries(folder_ / "absent"), 0u);
}

TEST_F(AtomicFiles, ErrorsNameTheFileAndTheReason) {
  AtomicFile absent(folder_ / "absent" / "x");
  EXPECT_NE(absent.commit().error().message.find(
                "absent/x: cannot create a temporary file beside it: No such file or directory"),
            std::string::npos);
  fs::create_directory(folder_ / "d");
  AtomicFile folder(folder_ / "d");
  EXPECT_NE(folder.commit().error().message.find("d: cannot be replaced: not a regular file"), std::string::npos);
}

TEST_F(AtomicFiles, FaultsAreKnownBeforeAnythingIsWritten) {
  EXPECT_FALSE(AtomicFile(folder_ / "x").fault());
  EXPECT_EQ(AtomicFile(folder_ / "absent" / "x").fault()->code, ErrorCode::io);
  EXPECT_NE(AtomicFile(folder_ / std::string(256, 'n')).fault()->message.find("File name too long"), std::string::npos);
  EXPECT_EQ(names(), Names{});
}

TEST_F(AtomicFiles, NothingIsWrittenThroughALink) {
  std::ofstream(folder_ / "victim") << "precious";
  fs::create_symlink("victim", folder_ / "to-file");
  fs::create_symlink("nowhere", folder_ / "to-nothing");
  fs::create_symlink("loop", folder_ / "loop");
  for (const char* name : {"to-file", "to-nothing", "loop"}) {
    for (const std::string_view kind : {"", "KIND"}) {
      AtomicFile file(folder_ / name, kind);
      file.append(bytes("KIND"));
      ASSERT_TRUE(file.fault());
      EXPECT_NE(file.fault()->message.find(std::string(name) + ": is a link to "), std::string::npos);
      EXPECT_FALSE(file.commit().ok());
    }
  }
  EXPECT_EQ(text("victim"), "precious");
  EXPECT_FALSE(fs::exists(folder_ / "nowhere"));
}

TEST_F(AtomicFiles, ALinkToAFileOfTheSameKindStaysAndTheFileIsReplaced) {
  std::ofstream(folder_ / "old") << "KIND one";
  fs::create_symlink("old", folder_ / "link");
  AtomicFile file(folder_ / "link", "KIND");
  file.append(bytes("KIND two"));
  ASSERT_TRUE(file.commit().ok());
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_EQ(text("old"), "KIND two");
}

}  // namespace
}  // namespace vcd
