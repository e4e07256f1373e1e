#include "enfilade/core/output_folder.h"

#include <gtest/gtest.h>
#include <filesystem>
#include <string>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "tests/support/temporary_folder.h"

namespace enfilade {
namespace EN_UNIT {

namespace fs = std::filesystem;

class OutputFolderTest : public ::testing::Test {
 protected:
  tests::TemporaryFolder temp_{"output_folder"};
  fs::path outside_ = temp_.path() / "outside";
  OutputFolder out_{temp_.path() / "p" / "out"};
  void SetUp() override { fs::create_directory(outside_); }
};

TEST_F(OutputFolderTest, WritesFilesAndFoldersBelowIt) {
  out_.write("a.txt", "1");
  out_.write("v/w/b c.txt", "2");
  out_.write("v/w/b c.txt", "3");
  EXPECT_EQ(read_file(out_.path() / "a.txt"), "1");
  EXPECT_EQ(read_file(out_.path() / "v" / "w" / "b c.txt"), "3");
  out_.folder("v/x").write("d.txt", "4");
  EXPECT_EQ(read_file(out_.path() / "v" / "x" / "d.txt"), "4");
  write_file_atomically(out_.file("y/e.txt"), "5");
  EXPECT_EQ(read_file(out_.path() / "y" / "e.txt"), "5");
  // Nothing unfinished stays.
  for (const auto& entry : fs::recursive_directory_iterator(out_.path())) {
    EXPECT_FALSE(is_unfinished(entry.path())) << entry.path();
  }
}

TEST_F(OutputFolderTest, RefusesNamesThatLeadElsewhere) {
  for (const char* name :
       {"", "/", "../x", "a/../x", "a//b", "/etc/x", "a/", "a\\b", ".x", "a\n"}) {
    EXPECT_THROW(out_.write(name, "x"), ArgumentError) << name;
    EXPECT_THROW(static_cast<void>(out_.file(name)), ArgumentError) << name;
    EXPECT_THROW(static_cast<void>(out_.folder(name)), ArgumentError) << name;
    EXPECT_THROW(out_.remove(name), ArgumentError) << name;
    EXPECT_THROW(static_cast<void>(out_.remove_empty(name)), ArgumentError) << name;
    EXPECT_THROW(out_.remove_all(name), ArgumentError) << name;
    EXPECT_THROW(out_.rename("a", name), ArgumentError) << name;
    EXPECT_THROW(out_.rename(name, "a"), ArgumentError) << name;
  }
  EXPECT_TRUE(fs::is_empty(out_.path()));
  EXPECT_FALSE(fs::exists(temp_.path() / "p" / "x"));
}

TEST_F(OutputFolderTest, FollowsNoLinkBelowIt) {
  fs::create_directory_symlink(outside_, out_.path() / "link");
  EXPECT_THROW(out_.write("link/x", "x"), FileError);
  EXPECT_THROW(static_cast<void>(out_.file("link/x")), FileError);
  EXPECT_THROW(static_cast<void>(out_.folder("link")), FileError);
  EXPECT_TRUE(fs::is_empty(outside_));

  // A link in place of a file is replaced, its target stays.
  write_file_atomically(outside_ / "kept", "old");
  fs::create_symlink(outside_ / "kept", out_.path() / "a");
  out_.write("a", "new");
  EXPECT_EQ(read_file(outside_ / "kept"), "old");
  EXPECT_EQ(read_file(out_.path() / "a"), "new");
  fs::create_symlink(outside_ / "kept", out_.path() / "b");
  write_file_atomically(out_.file("b"), "new");
  EXPECT_EQ(read_file(outside_ / "kept"), "old");
  fs::create_symlink(outside_ / "kept", out_.path() / "c");
  out_.remove("c");
  EXPECT_FALSE(fs::exists(out_.path() / "c"));
  EXPECT_EQ(read_file(outside_ / "kept"), "old");
}

TEST_F(OutputFolderTest, RemovesAndRenamesWhatIsBelowIt) {
  out_.write("a/b", "1");
  EXPECT_FALSE(out_.remove_empty("a"));
  out_.rename("a/b", "c/d");
  EXPECT_EQ(read_file(out_.path() / "c" / "d"), "1");
  EXPECT_TRUE(out_.remove_empty("a"));
  EXPECT_FALSE(out_.remove_empty("a"));
  out_.rename("c", "e");
  EXPECT_EQ(read_file(out_.path() / "e" / "d"), "1");
  out_.remove_all("e");
  EXPECT_TRUE(fs::is_empty(out_.path()));
  // Nothing is made for what is not there.
  out_.remove("f/g");
  out_.remove_all("f/g");
  out_.remove_unfinished("f/g");
  EXPECT_FALSE(out_.remove_empty("f/g"));
  EXPECT_TRUE(fs::is_empty(out_.path()));
}

TEST_F(OutputFolderTest, RemovesNothingBehindALink) {
  const fs::path kept = outside_ / "a.json.part999999999";
  write_file_atomically(kept, "half");
  fs::create_directory_symlink(outside_, out_.path() / "link");
  EXPECT_THROW(out_.remove("link/a.json.part999999999"), FileError);
  EXPECT_THROW(out_.remove_all("link/a.json.part999999999"), FileError);
  out_.remove_unfinished("link");
  EXPECT_THROW(out_.rename("link/a.json.part999999999", "b"), FileError);
  out_.remove_all("link");
  EXPECT_FALSE(fs::exists(fs::symlink_status(out_.path() / "link")));
  EXPECT_TRUE(fs::exists(kept));
}

// Whoever holds a folder holds its place, not what stands there later.
TEST_F(OutputFolderTest, FollowsNoLinkThatIsPlantedLater) {
  const OutputFolder held = out_.folder("a/b"), below = held.folder("c");
  EXPECT_EQ(below.path(), out_.path() / "a/b/c");
  below.write("x", "1");
  EXPECT_EQ(read_file(out_.path() / "a/b/c/x"), "1");
  make_folder(outside_ / "c");
  write_file_atomically(outside_ / "kept", "old");
  write_file_atomically(outside_ / "a.json.part999999999", "half");
  fs::rename(out_.path() / "a/b", out_.path() / "moved");
  fs::create_directory_symlink(outside_, out_.path() / "a/b");
  EXPECT_THROW(held.write("kept", "new"), FileError);
  EXPECT_THROW(below.write("x", "2"), FileError);
  EXPECT_THROW(static_cast<void>(held.file("kept")), FileError);
  EXPECT_THROW(static_cast<void>(held.folder("d")), FileError);
  EXPECT_THROW(held.remove("kept"), FileError);
  EXPECT_THROW(held.remove_all("c"), FileError);
  EXPECT_THROW(held.rename("kept", "x"), FileError);
  held.remove_unfinished();
  EXPECT_EQ(read_file(outside_ / "kept"), "old");
  EXPECT_EQ(std::distance(fs::recursive_directory_iterator(outside_), {}), 3);
}

TEST_F(OutputFolderTest, RemovesLinksWithinAFolderAndNotTheirTargets) {
  write_file_atomically(outside_ / "kept", "old");
  out_.write("a/b/c/d", "1");
  fs::create_directory_symlink(outside_, out_.path() / "a/b/link");
  fs::create_symlink(outside_ / "kept", out_.path() / "a/file");
  out_.remove_all("a");
  EXPECT_TRUE(fs::is_empty(out_.path()));
  EXPECT_EQ(read_file(outside_ / "kept"), "old");
}

TEST_F(OutputFolderTest, MakesNothingForAMissingFileThatIsRenamed) {
  EXPECT_THROW(out_.rename("a/b", "c/d"), FileError);
  EXPECT_THROW(out_.rename("a", "c/d"), FileError);
  EXPECT_TRUE(fs::is_empty(out_.path()));
}

TEST_F(OutputFolderTest, TakesNamesThatFitWithThoseOfTheirParts) {
  const std::string longest(243, 'a');
  out_.write(longest, "1");
  EXPECT_TRUE(OutputFolder::is_name(std::string(255, 'b') + "/" + longest));
  EXPECT_FALSE(OutputFolder::is_name(longest + "a"));
  EXPECT_FALSE(OutputFolder::is_name(std::string(256, 'b') + "/a"));
}

TEST_F(OutputFolderTest, ItsOwnPathMayBeALink) {
  const fs::path link = temp_.path() / "l";
  fs::create_directory_symlink(outside_, link);
  OutputFolder(link).write("x", "1");
  EXPECT_EQ(read_file(outside_ / "x"), "1");
}

TEST_F(OutputFolderTest, AFolderOrFileInTheWayIsAnError) {
  out_.write("a", "1");
  EXPECT_THROW(out_.write("a/b", "2"), FileError);
  static_cast<void>(out_.folder("d"));
  EXPECT_THROW(out_.write("d", "2"), FileError);
  EXPECT_EQ(read_file(out_.path() / "a"), "1");
}

}  // namespace EN_UNIT
}  // namespace enfilade
