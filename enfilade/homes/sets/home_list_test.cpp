#include "enfilade/homes/sets/home_list.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <filesystem>
#include <string>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::homes::sets {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class WrittenFilesTest : public ::testing::Test {
 protected:
  tests::TemporaryFolder temp_{"written_files"};
  fs::path outside_ = temp_.path() / "outside";
  fs::path out_ = temp_.path() / "out";
  void SetUp() override {
    fs::create_directory(outside_);
    fs::create_directory(out_);
    write_file_atomically(outside_ / "kept.json", "kept");
  }
  void list(const std::string& text) const {
    write_file_atomically(out_ / "annotations.txt", text);
  }
  bool kept() const { return fs::exists(outside_ / "kept.json"); }
};

TEST_F(WrittenFilesTest, ReplaceThoseOfTheRunBefore) {
  WrittenFiles before(out_);
  before.write("rxr/old/a.json", "1");
  before.write("r2r/a.json", "1");
  before.finish();
  WrittenFiles now(out_);
  now.write("r2r/a.json", "2");
  now.finish();
  EXPECT_EQ(read_file(out_ / "r2r/a.json"), "2");
  EXPECT_FALSE(fs::exists(out_ / "rxr")) << "folders that are empty then go too";
  EXPECT_EQ(read_file(out_ / "annotations.txt"), "r2r/a.json\n");
}

TEST_F(WrittenFilesTest, RemoveNothingOutsideThatAForeignListNames) {
  const std::string absolute = outside_ / "kept.json";
  for (const std::string& name :
       {std::string("../outside/kept.json"), std::string("r2r/../../outside/kept.json"), absolute,
        std::string("a//b"), std::string("./a"), std::string("a/")}) {
    list(name + "\n");
    EXPECT_THAT(tests::refusal<InvalidInput>([&] { WrittenFiles(out_).finish(); }),
                HasSubstr("annotations.txt: line 1: \"" + name.substr(0, 10)));
    EXPECT_TRUE(kept()) << name;
  }
}

TEST_F(WrittenFilesTest, RemoveAndWriteNothingBehindALink) {
  fs::create_directory_symlink(outside_, out_ / "rxr");
  list("rxr/kept.json\n");
  EXPECT_THAT(tests::refusal<FileError>([&] { WrittenFiles(out_).finish(); }),
              HasSubstr("rxr: cannot open: a link"));
  EXPECT_TRUE(kept());
  EXPECT_THROW(WrittenFiles(out_).write("rxr/new.json", "1"), FileError);
  EXPECT_FALSE(fs::exists(outside_ / "new.json"));
  // A link that the list itself names goes, and its target stays.
  fs::create_symlink(outside_ / "kept.json", out_ / "a.json");
  list("a.json\n");
  WrittenFiles(out_).finish();
  EXPECT_FALSE(fs::exists(fs::symlink_status(out_ / "a.json")));
  EXPECT_TRUE(kept());
}

}  // namespace EN_UNIT
}  // namespace enfilade::homes::sets
