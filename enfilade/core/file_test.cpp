#include "enfilade/core/file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <string>
#include <thread>

#include "enfilade/core/errors.h"
#include "enfilade/core/gzip.h"
#include "enfilade/core/mapped_file.h"
#include "tests/support/temporary_folder.h"

namespace enfilade {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class FileTest : public ::testing::Test {
 protected:
  const tests::TemporaryFolder made_{"file"};
  const fs::path& folder_ = made_.path();
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

TEST_F(FileTest, IsThereOrNotOrCannotBeFoundOut) {
  EXPECT_FALSE(file_exists(folder_ / "a"));
  write_file_atomically(folder_ / "a", "");
  EXPECT_TRUE(file_exists(folder_ / "a"));
  EXPECT_TRUE(file_exists(folder_));
  EXPECT_FALSE(file_exists(folder_ / "a" / "below a file"));
  fs::create_symlink("circle", folder_ / "circle");
  EXPECT_THAT([&] { file_exists(folder_ / "circle"); },
              ThrowsMessage<FileError>(HasSubstr((folder_ / "circle").string())));
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

TEST_F(FileTest, MakesAFolderWithThoseAboveIt) {
  make_folder(folder_ / "a" / "b");
  EXPECT_TRUE(fs::is_directory(folder_ / "a" / "b"));
  write_file_atomically(folder_ / "a" / "b" / "c", "kept");
  make_folder(folder_ / "a" / "b");  // it is there
  EXPECT_EQ(read_file(folder_ / "a" / "b" / "c"), "kept");
  fs::create_directory_symlink("a", folder_ / "link");
  make_folder(folder_ / "link");
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
}

TEST_F(FileTest, SaysWhyAFolderCannotBeMade) {
  write_file_atomically(folder_ / "file", "");
  for (const fs::path& path : {folder_ / "file", folder_ / "file" / "below"}) {
    EXPECT_THAT(
        [&] { make_folder(path); },
        ThrowsMessage<FileError>(path.string() + ": cannot make the folder: Not a directory"));
  }
}

TEST_F(FileTest, WritesToNoLinkThatStandsWhereThePartIsMade) {
  write_file_atomically(folder_ / "others", "old");
  fs::create_symlink("others", folder_ / ("a.part" + std::to_string(::getpid())));
  write_file_atomically(folder_ / "a", "new");
  EXPECT_EQ(read_file(folder_ / "others"), "old");
  EXPECT_EQ(read_file(folder_ / "a"), "new");
  EXPECT_FALSE(fs::is_symlink(folder_ / "a"));
}

// No process has so high a number.
constexpr const char* kNobody = ".part999999999";

TEST_F(FileTest, RemovesWhatKilledProcessesLeft) {
  fs::create_directories(folder_ / "below" / "b.part1");
  const std::string left = std::string("a.json") + kNobody;
  for (const std::string& name :
       {left, std::string("a.json"), std::string("a.part"), std::string("a.part12b"),
        std::string("part12"), std::string("a.12"), "below/" + left}) {
    write_file_atomically(folder_ / name, "");
  }
  remove_unfinished(folder_);
  EXPECT_FALSE(fs::exists(folder_ / left));
  EXPECT_EQ(std::distance(fs::recursive_directory_iterator(folder_), {}), 8) << "all the others";
  remove_unfinished(folder_ / "none");
  remove_unfinished(folder_ / "a.json");
}

TEST_F(FileTest, KeepsWhatAnotherProcessIsWriting) {
  const fs::path running = folder_ / "a.json.part1";  // there is always a process 1
  const fs::path own = folder_ / ("a.json.part" + std::to_string(::getpid()));
  write_file_atomically(running, "half");
  write_file_atomically(own, "half");
  remove_unfinished(folder_);
  EXPECT_TRUE(fs::exists(running));
  EXPECT_FALSE(fs::exists(own)) << "left by an earlier process that had the same number";
}

// Found where a killed job's processes had ended, and the machine's first process was busy.
TEST_F(FileTest, RemovesWhatAProcessLeftThatNobodyWaitedFor) {
  const pid_t process = ::fork();
  ASSERT_GE(process, 0);
  if (process == 0) ::_exit(0);
  siginfo_t ended{};
  ASSERT_EQ(::waitid(P_PID, static_cast<id_t>(process), &ended, WEXITED | WNOWAIT), 0);
  const fs::path left = folder_ / ("a.json.part" + std::to_string(process));
  write_file_atomically(left, "half");
  remove_unfinished(folder_);
  EXPECT_FALSE(fs::exists(left));
  ASSERT_EQ(::waitpid(process, nullptr, 0), process);
}

TEST_F(FileTest, RemovesUnfinishedFilesOfChosenNamesOnly) {
  for (const char* name : {"a.json", "b.tar"}) {
    write_file_atomically(folder_ / (std::string(name) + kNobody), "half");
  }
  remove_unfinished(folder_, ".json");
  EXPECT_FALSE(fs::exists(folder_ / (std::string("a.json") + kNobody)));
  EXPECT_TRUE(fs::exists(folder_ / (std::string("b.tar") + kNobody)));
}

// As `-o /dev/stdout | less` has it: a link whose target has no name.
TEST_F(FileTest, WritesIntoPipes) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  write_file_atomically("/proc/self/fd/" + std::to_string(ends[1]), "text");
  ::close(ends[1]);
  char bytes[8];
  EXPECT_EQ(::read(ends[0], bytes, sizeof bytes), 4);
  EXPECT_EQ(std::string(bytes, 4), "text");
  ::close(ends[0]);
}

TEST_F(FileTest, ReadsAPipeToItsEnd) {
  const fs::path pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const std::string text(300'000, 'x');
  // Open before the reader looks, however late the thread begins.
  const int end = ::open(pipe.c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_GE(end, 0);
  const std::jthread writer([&] {
    std::ofstream out(pipe, std::ios::binary);
    out << text << std::flush;  // more than a pipe holds: then the reader has opened it, too
    ::close(end);
    std::this_thread::sleep_for(std::chrono::milliseconds(2200));  // longer than the patience
    out << "end";
  });
  EXPECT_EQ(read_file(pipe), text + "end");
}

// Each would hang, or take all memory.
TEST_F(FileTest, WhatHasNoEndOrNoWriterIsRefused) {
  const fs::path pipe = folder_ / "pipe", sparse = folder_ / "sparse";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  write_file_atomically(sparse, "");
  fs::resize_file(sparse, std::uintmax_t{1} << 40U);
  EXPECT_THAT([&] { read_file(pipe); },
              ThrowsMessage<FileError>(HasSubstr("a pipe that no program writes to")));
  EXPECT_THAT([] { read_file("/dev/zero"); },
              ThrowsMessage<FileError>("/dev/zero: cannot read: more than 67108864 bytes"));
  EXPECT_THAT([] { read_file("/dev/zero", 10); },
              ThrowsMessage<FileError>(HasSubstr("more than 10 bytes")));
  EXPECT_THAT([&] { read_file(sparse); },
              ThrowsMessage<FileError>(HasSubstr("more than 4294967296 bytes")));
  EXPECT_EQ(read_file("/dev/null"), "");
  for (const fs::path& odd : {pipe, fs::path("/dev/zero"), folder_}) {
    EXPECT_THROW(check_plain_file(odd), FileError) << odd;
    EXPECT_THROW(MappedFile{odd}, FileError) << odd;
    EXPECT_THROW(text_beginning(odd, 10), FileError) << odd;
  }
  check_plain_file(sparse);
  check_plain_file(folder_ / "none");
}

TEST_F(FileTest, AFullDiskIsAnError) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full on this system";
  EXPECT_THAT([&] { write_file_atomically("/dev/full", "x"); },
              ThrowsMessage<FileError>(HasSubstr("No space left")));
}

}  // namespace EN_UNIT
}  // namespace enfilade
