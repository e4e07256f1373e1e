#include "enfilade/core/part_file.h"

#include <gmock/gmock.h>
#include <array>
#include <csignal>
#include <string_view>

#include <sys/resource.h>
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "tests/support/temporary_folder.h"

namespace enfilade {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

std::span<const std::byte> bytes(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

class PartFileTest : public ::testing::Test {
 protected:
  tests::TemporaryFolder folder_{"part_file"};
  fs::path file_ = folder_.path() / "f";
  fs::path part_ = folder_.path() / "f.part";
};

TEST_F(PartFileTest, TheFileIsAsBeforeUntilItIsFinished) {
  write_file_atomically(file_, "old");
  PartFile part(file_);
  part.write_at(4, bytes("5678"));
  part.write_at(0, bytes("1234"));
  EXPECT_EQ(part.size(), 8U);
  EXPECT_EQ(read_file(file_), "old");
  part.finish();
  EXPECT_EQ(read_file(file_), "12345678");
  EXPECT_FALSE(fs::exists(part_));
}

TEST_F(PartFileTest, WhoOpensItAgainFindsWhatWasWritten) {
  PartFile(file_).write_at(0, bytes("1234"));
  PartFile part(file_);
  EXPECT_EQ(part.size(), 4U);
  part.resize(2);
  part.resize(3);
  EXPECT_EQ(read_file(part_), std::string_view("12\0", 3));
  part.remove();
  EXPECT_FALSE(fs::exists(part_));
}

TEST_F(PartFileTest, IsOneWritersAtATime) {
  const PartFile part(file_);
  EXPECT_THAT(
      [&] { PartFile second(file_); },
      ThrowsMessage<FileError>(part_.string() + ": another process is writing it just now"));
}

TEST_F(PartFileTest, LiesBesideWhatALinkPointsTo) {
  write_file_atomically(folder_.path() / "real", "old");
  fs::create_symlink("real", file_);
  PartFile part(file_);
  part.write_at(0, bytes("new"));
  part.finish();
  EXPECT_TRUE(fs::is_symlink(file_));
  EXPECT_EQ(read_file(folder_.path() / "real"), "new");
}

TEST_F(PartFileTest, FollowsNoLinkInPlaceOfThePart) {
  write_file_atomically(folder_.path() / "others", "old");
  fs::create_symlink("others", part_);
  EXPECT_THAT([&] { PartFile part(file_); },
              ThrowsMessage<FileError>(AllOf(HasSubstr("f.part"), HasSubstr("a link"))));
  EXPECT_THROW(FolderLock lock(part_), FileError);
  EXPECT_EQ(read_file(folder_.path() / "others"), "old");
}

TEST_F(PartFileTest, ReplacesPlainFilesOnly) {
  EXPECT_THAT([&] { PartFile part(folder_.path()); },
              ThrowsMessage<FileError>(HasSubstr("no plain file")));
  EXPECT_THAT([&] { PartFile part(folder_.path() / "none" / "f"); },
              ThrowsMessage<FileError>(AllOf(HasSubstr("f.part"), HasSubstr("No such file"))));
}

TEST_F(PartFileTest, AFullDiskIsAnError) {
  // A limit on the size of files stands in for the end of the disk.
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{4096, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  PartFile part(file_);
  const std::array<std::byte, 5000> content{};
  EXPECT_THAT([&] { part.write_at(0, content); },
              ThrowsMessage<FileError>(AllOf(HasSubstr(part_.string()), HasSubstr("too large"))));
  EXPECT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
}

}  // namespace EN_UNIT
}  // namespace enfilade
