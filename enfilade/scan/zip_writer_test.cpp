
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/scan/file_tree.h"

namespace enfilade::scan {
namespace EN_UNIT {

using ::testing::ElementsAre;

TEST(ZipWriter, WhatItWritesIsReadBack) {
  const std::vector<ZipEntry> entries{
      {"b.npy", std::string("\0\x93 bytes", 8)}, {"a.npy", ""}, {"long", std::string(200000, 'x')}};
  const std::string bytes = zip(entries);
  EXPECT_LT(bytes.size(), 2000U);  // deflated
  EXPECT_EQ(zip(entries), bytes);
  const auto tree = FileTree::zip_in_memory(bytes, "made.zip");
  EXPECT_THAT(tree->names(), ElementsAre("a.npy", "b.npy", "long"));
  for (const ZipEntry& entry : entries) EXPECT_EQ(tree->read(entry.name), entry.content);
}

TEST(ZipWriter, AnEmptyOneHasNoEntries) {
  EXPECT_THAT(FileTree::zip_in_memory(zip({}), "made.zip")->names(), ElementsAre());
}

TEST(ZipWriter, RefusesWhatAZipCannotSay) {
  EXPECT_THROW(zip(std::vector<ZipEntry>{{"", "x"}}), ArgumentError);
  EXPECT_THROW(zip(std::vector<ZipEntry>{{std::string(65536, 'n'), "x"}}), ArgumentError);
  EXPECT_THROW(zip(std::vector<ZipEntry>{{"a", "x"}, {"a", "y"}}), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::scan
