#include "enfilade/core/file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/core/errors.h"

namespace enfilade {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::ThrowsMessage;

class FileTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        fs::path(testing::TempDir()) /
        (std::string("file_test_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path folder_;
};

TEST_F(FileTest, ComesBackAsWritten) {
  const std::string content("line\0with zero\n", 15);
  write_file_atomically(folder_ / "a", content);
  EXPECT_EQ(read_file(folder_ / "a"), content);
  write_file_atomically(folder_ / "a", "shorter");
  EXPECT_EQ(read_file(folder_ / "a"), "shorter");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1) << "no part file stays behind";
}

TEST_F(FileTest, KeepsALinkAndWritesWhatItPointsTo) {
  write_file_atomically(folder_ / "real", "old");
  fs::create_symlink("real", folder_ / "link");
  write_file_atomically(folder_ / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_EQ(read_file(folder_ / "real"), "new");
}

TEST_F(FileTest, SaysWhichFileAndWhy) {
  EXPECT_THAT([&] { read_file(folder_ / "none"); },
              ThrowsMessage<FileError>(HasSubstr("none: cannot open: No such file")));
  EXPECT_THAT([&] { read_file(folder_); }, ThrowsMessage<FileError>(HasSubstr("Is a directory")));
  EXPECT_THAT([&] { write_file_atomically(folder_ / "no" / "such", "x"); },
              ThrowsMessage<FileError>(HasSubstr("such: cannot write: No such file")));
  EXPECT_THAT([&] { write_file_atomically(folder_, "x"); },
              ThrowsMessage<FileError>(HasSubstr("Is a directory")));
}

TEST_F(FileTest, AFullDiskIsAnError) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full on this system";
  EXPECT_THAT([&] { write_file_atomically("/dev/full", "x"); },
              ThrowsMessage<FileError>(HasSubstr("No space left")));
}

}  // namespace
}  // namespace enfilade
