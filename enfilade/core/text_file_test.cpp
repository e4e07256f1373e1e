#include "enfilade/core/gzip.h"

#include <gtest/gtest.h>

#include <string>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "tests/support/temporary_folder.h"

namespace enfilade {
namespace EN_UNIT {

TEST(TextFile, HasTheTextOfSmallLargeAndPackedFiles) {
  const tests::TemporaryFolder folder("text_file");
  const auto path = folder.path() / "text";
  std::string large;
  for (int k = 0; k < 300000; ++k) large += std::to_string(k) + '\n';
  for (const std::string& text : {std::string(), std::string("small"), large}) {
    write_file_atomically(path, text);
    EXPECT_EQ(TextFile(path).text(), text);
    write_file_atomically(path, gzip(text, 1));
    EXPECT_EQ(TextFile(path).text(), text);
  }
  // Packed so badly that it is large itself.
  write_file_atomically(path, gzip(large, 0));
  EXPECT_EQ(TextFile(path).text(), large);
  EXPECT_THROW(TextFile(path, 1000), FileError);
}

TEST(TextFile, NamesWhatCannotBeRead) {
  const tests::TemporaryFolder folder("text_file");
  EXPECT_THROW(TextFile(folder.path() / "none"), FileError);
  EXPECT_THROW(TextFile(folder.path()), FileError);
}

}  // namespace EN_UNIT
}  // namespace enfilade
