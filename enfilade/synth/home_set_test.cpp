#include "enfilade/synth/home_set.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/r2r/annotations.h"
#include "enfilade/scan/data_root.h"
#include "enfilade/scan/store.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::synth {
namespace {

namespace fs = std::filesystem;

HomeSetOptions tiny(std::size_t homes, std::uint32_t face_size) {
  HomeSetOptions options;
  options.homes = homes;
  options.kind = HomeKind::kFlat;
  options.least_area = options.most_area = 60;
  options.face_size = face_size;
  options.samples = 1;
  return options;
}

std::map<std::string, std::string> bytes_in(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) {
      files[fs::relative(entry.path(), folder).string()] = read_file(entry.path());
    }
  }
  return files;
}

TEST(HomeSet, HasPicturesAtEveryViewpointAndTheSameBytesAgain) {
  const tests::TemporaryFolder a("homes_a"), b("homes_b");
  const auto homes = write_homes(a.path(), tiny(1, 8));
  ASSERT_EQ(homes.size(), 1U);
  EXPECT_GT(homes[0].viewpoints, 5U);
  const auto store = scan::Store::open(scan::store_file(a.path() / "store", homes[0].scan));
  EXPECT_EQ(store->size(), homes[0].viewpoints);
  EXPECT_TRUE(store->verify().empty());
  for (std::size_t v = 0; v < store->size(); ++v) {
    EXPECT_EQ(store->face_sizes(ViewpointIndex(v)), (scan::FaceSizes{8, 8, 8, 8}));
  }
  HomeSetOptions one_thread = tiny(1, 8);
  one_thread.threads = 1;
  write_homes(b.path(), one_thread);
  EXPECT_EQ(bytes_in(a.path()), bytes_in(b.path()));
}

TEST(HomeSet, GoesOnWhereItWasAndRefusesWhatIsNotItsOwn) {
  const tests::TemporaryFolder folder("homes");
  write_homes(folder.path(), tiny(1, 0));
  const auto whole = bytes_in(folder.path());
  // Killed after the graph was written and before the list was.
  fs::remove(folder.path() / "homes.json");
  write_homes(folder.path(), tiny(1, 0));
  EXPECT_EQ(bytes_in(folder.path()), whole);
  EXPECT_THROW(write_homes(folder.path(), tiny(2, 0)), FileError);

  const tests::TemporaryFolder other("homes_other");
  write_file_atomically(other.path() / "thesis.tex", "years of work");
  EXPECT_THROW(write_homes(other.path(), tiny(1, 0)), FileError);
  EXPECT_THROW(write_homes(other.path() / "new", tiny(0, 0)), ArgumentError);
  write_file_atomically(folder.path() / "homes.json", "{\"format\": \"enfilade-homes\"}");
  EXPECT_THROW(read_home_list(folder.path()), InvalidInput);
}

TEST(HomeSet, PathsHaveThreeInstructionsAndHiddenGoals) {
  const tests::TemporaryFolder folder("homes");
  write_homes(folder.path(), tiny(3, 0));
  HomePathOptions options;
  options.per_home = 6;
  const HomePathReport report = write_home_paths(folder.path(), options);
  EXPECT_GT(report.paths, 6U);
  EXPECT_EQ(report.instructions, 3 * report.paths);
  const scan::DataRoot data(folder.path());
  const auto test = r2r::load_annotations(data.annotations("test"), "test");
  const auto hidden = r2r::load_annotations(folder.path() / "hidden" / "R2R_test.json", "test");
  ASSERT_EQ(test.paths.size(), hidden.paths.size());
  for (std::size_t i = 0; i < test.paths.size(); ++i) {
    EXPECT_EQ(test.paths[i].path.size(), 1U);
    EXPECT_GT(hidden.paths[i].path.size(), 4U);
    EXPECT_EQ(test.paths[i].instructions, hidden.paths[i].instructions);
    EXPECT_EQ(test.paths[i].instructions.size(), 3U);
  }
}

}  // namespace
}  // namespace enfilade::synth
