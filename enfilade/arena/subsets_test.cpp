#include "enfilade/arena/world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/dataset/dataset.h"
#include "tests/support/grid_world.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::arena {
namespace EN_UNIT {

using arena::testing::episodes;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using tests::refusal;

TEST(Subsets, AreSpreadEvenly) {
  const GraphWorld all(episodes(tasks::Task::kR2r, 40));
  const std::size_t size = all.size();
  EXPECT_EQ(spread_subset(all, size).size(), size);
  EXPECT_EQ(spread_subset(all, 7).size(), 7U);
  EXPECT_EQ(spread_subset(all, 7), spread_subset(all, 7));
  EXPECT_THAT(refusal<ArgumentError>([&] { spread_subset(all, size + 1); }), HasSubstr("has 81"));
  EXPECT_THAT(refusal<ArgumentError>([&] { spread_subset(all, 0); }), HasSubstr("subset of 0"));
}

TEST(Subsets, ChanceIsABinomials) {
  EXPECT_NEAR(chance_of(100), 0.098, 5e-4);
  EXPECT_NEAR(chance_of(216), 0.0667, 5e-4);
  EXPECT_NEAR(chance_of(1000), 0.031, 5e-4);
}

TEST(Subsets, FilesNameEpisodes) {
  const GraphWorld all(episodes(tasks::Task::kR2r, 2));
  const tests::TemporaryFolder folder("subsets");
  const auto file = folder.path() / "ids.txt";
  const auto fault = [&](const std::string& text) {
    write_file_atomically(file, text);
    return refusal<InvalidInput>([&] { listed_subset(all, file); });
  };
  write_file_atomically(file, "# two\n3_1\n 1_0 \n\n");
  EXPECT_THAT(listed_subset(all, file), ElementsAre(0, 4));
  for (const char* saved : {"\xEF\xBB\xBF"
                            "3_1\r\n1_0\r\n\r\n",
                            "\xEF\xBB\xBF# two\r3_1\r1_0\t\r"}) {
    write_file_atomically(file, saved);
    EXPECT_THAT(listed_subset(all, file), ElementsAre(0, 4)) << saved;
  }
  EXPECT_THAT(fault("1_0\n9_9\n1_0"), HasSubstr("line 2: \"9_9\" is no episode of the split"));
  EXPECT_THAT(fault("1_0\n9_9\n1_0"), HasSubstr("line 3: \"1_0\" is there twice"));
  EXPECT_THAT(fault("# none"), HasSubstr("no id in it"));
}

// Recorded: papers name these subsets, so they must not change.
TEST(Subsets, OfRoomToRoomAreWhatTheyWere) {
  const auto data = dataset::Dataset::from_environment();
  if (!data || !data->has_split("val_unseen"))
    GTEST_SKIP() << "ENFILADE_DATA has no R2R val_unseen";
  const GraphWorld world(std::make_shared<const tasks::EpisodeSet>(data->episodes("val_unseen")));
  const tasks::EpisodeSet& all = *world.episodes().on_graph();
  ASSERT_EQ(world.size(), 2349U);
  for (const std::size_t count : {100U, 216U, 1000U}) {
    const auto chosen = spread_subset(world, count);
    std::map<std::size_t, std::size_t> by_scan, of_all;
    for (const std::size_t e : chosen) ++by_scan[all.path_of(all.episodes[e]).scan.at()];
    for (const tasks::Episode& one : all.episodes) ++of_all[all.path_of(one).scan.at()];
    EXPECT_EQ(by_scan.size(), 11U);
    for (const auto& [scan, number] : of_all) {
      const double due = static_cast<double>(number * count) / 2349.0;
      EXPECT_NEAR(static_cast<double>(by_scan[scan]), due, 1.01) << count;
    }
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::arena
