#include <vcd/library/find.h>
#include "common/paths.h"

#include <gtest/gtest.h>

#include <fstream>

#include <sys/stat.h>
#include <unistd.h>

#include "support/files.h"

namespace vcd::library {

using namespace tools;
namespace {

namespace fs = std::filesystem;

class Find : public ::testing::Test {
 protected:
  fs::path file(const fs::path& name) {
    const fs::path path = folder_.path() / name;
    fs::create_directories(path.parent_path());
    std::ofstream(path) << "x";
    return path;
  }

  // What is found, as "below" lists it.
  std::vector<std::string> found(const std::vector<std::string>& inputs) {
    last_ = find_files(inputs, baker::mesh_extensions());
    std::vector<std::string> names;
    for (const FoundFile& f : last_.files) names.push_back(f.below.string());
    return names;
  }

  std::string root() const { return folder_.path().string(); }
  using Names = std::vector<std::string>;

  test::TemporaryFolder folder_;
  Found last_;
};

TEST_F(Find, FoldersAreSearchedInTheOrderOfNames) {
  file("b.obj"), file("a/z.PLY"), file("a/b/c.glb"), file("a/c.png"), file(".git/x.obj"), file(".hidden.obj");
  EXPECT_EQ(found({root()}), (Names{"a/b/c.glb", "a/z.PLY", "b.obj"}));
  EXPECT_EQ(last_.other_files, 1u);
}

TEST_F(Find, ANamedFileIsTakenWhateverItsExtension) {
  const std::string odd = file("odd.xyz").string();
  EXPECT_EQ(found({odd}), Names{"odd.xyz"});
}

TEST_F(Find, EachPathOnce) {
  const std::string one = file("a/one.obj").string();
  EXPECT_EQ(found({one, root(), root() + "/a/", root() + "/a/../a/one.obj"}), Names{"one.obj"});
  EXPECT_EQ(last_.named_again, 3u);
}

TEST_F(Find, LoopsOfLinksEndAndLinkedFilesCount) {
  file("a/one.obj");
  fs::create_directory_symlink("..", folder_.path() / "a" / "up");
  fs::create_directory_symlink("a", folder_.path() / "again");
  fs::create_symlink("one.obj", folder_.path() / "a" / "two.obj");
  EXPECT_EQ(found({root()}), (Names{"a/one.obj", "a/two.obj"}));
  EXPECT_TRUE(last_.errors.empty());
  EXPECT_EQ(found({root() + "/**/*.obj"}), (Names{"a/one.obj", "a/two.obj"}));
  EXPECT_TRUE(last_.errors.empty());
  EXPECT_EQ(last_.named_again, 0u);
}

TEST_F(Find, ALinkToNothingIsAnError) {
  fs::create_symlink("nowhere", folder_.path() / "lost.obj");
  fs::create_symlink("self.obj", folder_.path() / "self.obj");
  EXPECT_EQ(found({root()}), Names{});
  ASSERT_EQ(last_.errors.size(), 2u);
  EXPECT_EQ(last_.errors[0].message, root() + "/lost.obj: No such file or directory");
  EXPECT_EQ(last_.errors[1].message, root() + "/self.obj: Too many levels of symbolic links");
}

TEST_F(Find, PatternsMatchWithinAndAcrossFolders) {
  file("a1.obj"), file("a2.ply"), file("b/a3.obj"), file("b/c/a4.obj"), file("b/c/x.obj"), file(".a.obj");
  EXPECT_EQ(found({root() + "/a*.obj"}), Names{"a1.obj"});
  EXPECT_EQ(found({root() + "/*/a?.obj"}), Names{"b/a3.obj"});
  EXPECT_EQ(found({root() + "/**/a[34].obj"}), (Names{"b/a3.obj", "b/c/a4.obj"}));
  EXPECT_EQ(found({root() + "/**/a*"}), (Names{"a1.obj", "a2.ply", "b/a3.obj", "b/c/a4.obj"}));
  EXPECT_EQ(found({root() + "/z*.obj"}), Names{});
  ASSERT_EQ(last_.errors.size(), 1u);
  EXPECT_NE(last_.errors[0].message.find("no file matches"), std::string::npos);
}

TEST_F(Find, AFileWhoseNameLooksLikeAPatternIsThatFile) {
  file("[x]*.obj"), file("x.obj");
  EXPECT_EQ(found({root() + "/[x]*.obj"}), Names{"[x]*.obj"});
}

TEST_F(Find, WhatCannotBeReadIsNamed) {
  EXPECT_EQ(found({root() + "/none.obj"}), Names{});
  ASSERT_EQ(last_.errors.size(), 1u);
  EXPECT_EQ(last_.errors[0].code, ErrorCode::io);
  EXPECT_EQ(last_.errors[0].message, root() + "/none.obj: No such file or directory");
  if (geteuid() == 0) GTEST_SKIP() << "root reads every folder";
  file("closed/x.obj");
  fs::permissions(folder_.path() / "closed", fs::perms::none);
  found({root()});
  EXPECT_EQ(last_.errors.size(), 1u);
  fs::permissions(folder_.path() / "closed", fs::perms::owner_all);
}

TEST_F(Find, NamesOfAnyBytesAreFoundAndShown) {
  file("a b'\"\n\xff.obj"), file("\xc3\xa4.obj");
  EXPECT_EQ(found({root()}), (Names{"a b'\"\n\xff.obj", "\xc3\xa4.obj"}));
  EXPECT_EQ(shown("a\n\xff"), "a\\x0a\\xff");
  EXPECT_EQ(shown("\xc3\xa4\t"), "\xc3\xa4\\x09");
}

}  // namespace
}  // namespace vcd::library
