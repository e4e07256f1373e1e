#include "enfilade/scan/file_tree.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/threads.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/zip_bytes.h"

namespace enfilade::scan {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Optional;
using ::testing::StartsWith;
using testing::zip_of;
using tests::refusal;
using tests::TemporaryFolder;

constexpr std::size_t kMany = 200;

std::string small_zip() {
  return zip_of({{"s/kind/b.txt", "of b"}, {"s/kind/", ""}, {"a.txt", std::string(5000, 'a')}});
}

std::string refusal_of_zip(const std::string& bytes) {
  return refusal<InvalidInput>([&] {
    const auto tree = FileTree::zip_in_memory(bytes, "x.zip");
    for (const std::string& name : tree->names()) tree->read(name);
  });
}

void expect_same_files(const FileTree& tree) {
  EXPECT_THAT(tree.names(), ElementsAre("a.txt", "b.txt"));
  EXPECT_THAT(tree.read("b.txt"), Optional(std::string("of b")));
  EXPECT_THAT(tree.read("a.txt"), Optional(std::string(5000, 'a')));
  EXPECT_THAT(tree.read_start("a.txt", 3), Optional(std::string("aaa")));
  EXPECT_THAT(tree.read_start("b.txt", 100), Optional(std::string("of b")));
  EXPECT_TRUE(tree.contains("a.txt"));
  for (const char* none : {"c.txt", "", ".", "..", "kind", "s", "s/kind/b.txt", "../a.txt"}) {
    EXPECT_FALSE(tree.contains(none)) << none;
    EXPECT_EQ(tree.read(none), std::nullopt) << none;
  }
}

TEST(FileTree, IsAFolder) {
  const TemporaryFolder scratch("file_tree_1");
  write_file_atomically(scratch.path() / "b.txt", "of b");
  write_file_atomically(scratch.path() / "a.txt", std::string(5000, 'a'));
  fs::create_directory(scratch.path() / "kind");
  const auto tree = FileTree::folder(scratch.path());
  expect_same_files(*tree);
  EXPECT_EQ(tree->path_of("a.txt"), (scratch.path() / "a.txt").string());
}

TEST(FileTree, IsAZipWithItsFilesAnywhereInIt) {
  const TemporaryFolder scratch("file_tree_2");
  write_file_atomically(scratch.path() / "kind.zip", small_zip());
  const auto tree = FileTree::zip(scratch.path() / "kind.zip");
  expect_same_files(*tree);
  EXPECT_EQ(tree->path_of("a.txt"), (scratch.path() / "kind.zip").string() + ":a.txt");
  expect_same_files(*FileTree::zip_in_memory(small_zip(), "x.zip"));
}

TEST(FileTree, TellsWhenAFileChanges) {
  const TemporaryFolder scratch("file_tree_state");
  const fs::path a = scratch.path() / "a", zip = scratch.path() / "x.zip";
  write_file_atomically(a, "1");
  write_file_atomically(zip, small_zip());
  const auto folder_state = [&] { return FileTree::folder(scratch.path())->state(); };
  const auto zip_state = [&] { return FileTree::zip(zip)->state(); };
  const std::string folder_before = folder_state(), zip_before = zip_state();
  EXPECT_EQ(folder_state(), folder_before);
  EXPECT_EQ(zip_state(), zip_before);
  write_file_atomically(a, "12");
  EXPECT_NE(folder_state(), folder_before);
  EXPECT_EQ(zip_state(), zip_before);
  fs::last_write_time(zip, fs::last_write_time(zip) + std::chrono::seconds(1));
  EXPECT_NE(zip_state(), zip_before);
  EXPECT_NE(FileTree::zip_in_memory(small_zip(), "m")->state(),
            FileTree::zip_in_memory(zip_of({{"a.txt", "1"}}), "m")->state());
}

TEST(FileTree, SaysWhatIsNotThere) {
  const TemporaryFolder scratch("file_tree_3");
  write_file_atomically(scratch.path() / "file", "text");
  const auto path = [&](const char* name) { return scratch.path() / name; };
  EXPECT_THAT(refusal<FileError>([&] { FileTree::folder(path("none")); }),
              AllOf(StartsWith(path("none").string()), HasSubstr("No such file or directory")));
  EXPECT_THAT(refusal<FileError>([&] { FileTree::folder(path("file")); }),
              HasSubstr("Not a directory"));
  EXPECT_THAT(refusal<FileError>([&] { FileTree::zip(path("none")); }),
              AllOf(StartsWith(path("none").string()), HasSubstr("No such file")));
  EXPECT_THAT(refusal<FileError>([&] { FileTree::zip(scratch.path()); }),
              HasSubstr("Is a directory"));
}

TEST(FileTree, RefusesWhatIsNoWholeZip) {
  const std::string zip = small_zip();
  EXPECT_THAT(refusal_of_zip(""), HasSubstr("x.zip: an empty file, no zip [no-zip]"));
  EXPECT_THAT(refusal_of_zip(std::string(1000, 'x')), HasSubstr("[no-zip]"));
  EXPECT_THAT(refusal_of_zip(zip.substr(0, zip.size() / 2)),
              HasSubstr("x.zip: no zip file, or one that is cut off"));
  for (std::size_t cut = 1; cut < zip.size(); ++cut) {
    ASSERT_THAT(refusal_of_zip(zip.substr(0, zip.size() - cut)), HasSubstr("zip]")) << cut;
  }
}

TEST(FileTree, ComparesChecksums) {
  std::string zip = zip_of({{"d/a.txt", "abcdefghij"}});
  const std::size_t at = zip.find("abcdefghij");  // too short to be deflated
  ASSERT_NE(at, std::string::npos);
  zip[at + 3] = 'D';
  EXPECT_THAT(refusal_of_zip(zip), AllOf(HasSubstr("x.zip:a.txt: a damaged entry"),
                                         HasSubstr("CRC error"), HasSubstr("[bad-zip]")));
}

TEST(FileTree, RefusesEveryFlippedBitThatMatters) {
  // Whatever a flipped bit does, it is a refusal, or no file's content is changed by it.
  const std::string whole = zip_of({{"d/a.txt", "abcdefghij"}, {"b.txt", std::string(3000, 'b')}});
  std::size_t refused = 0;
  for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
    std::string zip = whole;
    zip[bit / 8] = static_cast<char>(zip[bit / 8] ^ 1 << bit % 8);
    try {
      const auto tree = FileTree::zip_in_memory(zip, "x.zip");
      ASSERT_EQ(tree->read("a.txt").value_or("abcdefghij"), "abcdefghij") << bit;
      ASSERT_EQ(tree->read("b.txt").value_or(std::string(3000, 'b')), std::string(3000, 'b'))
          << bit;
    } catch (const InvalidInput&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, whole.size());
}

TEST(FileTree, RefusesEncryptedEntries) {
  EXPECT_THAT(refusal_of_zip(zip_of({{"d/a.txt", "secret", "word"}})),
              HasSubstr("x.zip: \"d/a.txt\" is encrypted, which is not read [encrypted]"));
}

TEST(FileTree, RefusesAnEntryThatClaimsMuchMoreThanItsBytes) {
  // The entry's size, in the list at the end: 24 bytes after that record's signature.
  std::string zip = zip_of({{"a.txt", std::string(100000, 'a')}});
  const std::size_t record = zip.find("PK\1\2");
  ASSERT_NE(record, std::string::npos);
  zip[record + 24 + 3] = 0x7f;
  EXPECT_THAT(refusal_of_zip(zip), AllOf(HasSubstr("x.zip:a.txt: 2130806432 bytes from"),
                                         HasSubstr("at most 67108864 are read")));
  zip[record + 24 + 3] = 0x03;  // within what is read, and still not true
  EXPECT_THAT(refusal_of_zip(zip), HasSubstr("less than the 50431648 bytes that are listed"));
  zip[record + 24 + 3] = 0;
  zip[record + 24 + 2] = 0;
  EXPECT_THAT(refusal_of_zip(zip), HasSubstr("more than the 34464 bytes that are listed"));
}

TEST(FileTree, RefusesAnAmbiguousName) {
  const auto tree =
      FileTree::zip_in_memory(zip_of({{"a/x", "1"}, {"b/x", "2"}, {"b/y", "3"}}), "x.zip");
  EXPECT_THAT(tree->read("y"), Optional(std::string("3")));
  EXPECT_THAT(refusal<InvalidInput>([&] { tree->read("x"); }),
              HasSubstr("x.zip:x: lies in two folders of the zip, one of them \"a/x\""));
}

TEST(FileTree, IsReadByManyThreads) {
  std::vector<testing::ZipEntry> entries;
  for (std::size_t i = 0; i < kMany; ++i) {
    entries.push_back({"d/" + std::to_string(i), std::string(10000 + i, 'x'), ""});
  }
  const TemporaryFolder scratch("file_tree_4");
  write_file_atomically(scratch.path() / "many.zip", zip_of(entries));
  const auto tree = FileTree::zip(scratch.path() / "many.zip");
  parallel_for(4 * kMany, 1, 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t k = i % kMany;
      if (tree->read(std::to_string(k)) != entries[k].content) throw ArgumentError("wrong content");
    }
  });
}

TEST(FileTree, NoticesThatAZipWasReplaced) {
  const TemporaryFolder scratch("file_tree_5");
  const fs::path path = scratch.path() / "x.zip";
  std::string zip = zip_of({{"broken", "abcdefghij"}, {"a", "of a"}, {"b", "of b"}});
  zip[zip.find("abcdefghij")] = 'A';
  write_file_atomically(path, zip);
  const auto tree = FileTree::zip(path);
  write_file_atomically(path, zip_of({{"b", "of b"}, {"a", "of a"}}));
  EXPECT_THAT(tree->read("a"), Optional(std::string("of a"))) << "the old file is open still";
  // A handle that met a fault is given up, so that the next reader opens the file again.
  EXPECT_THROW(tree->read("broken"), InvalidInput);
  EXPECT_THAT(refusal<FileError>([&] { tree->read("b"); }),
              HasSubstr("x.zip:b: the zip file was changed while it was read"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::scan
