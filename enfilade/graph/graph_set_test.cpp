#include "enfilade/graph/graph_set.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "tests/support/graphs.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::graph {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class GraphSetTest : public ::testing::Test {
 protected:
  void SetUp() override {
    write_file_atomically(folder_ / "scans.txt", "one\ntwo\n");
    write_file_atomically(folder_ / "one_connectivity.json", to_json(testing::square("one")));
  }

  const tests::TemporaryFolder made_{"graph_set"};
  const fs::path& folder_ = made_.path();
};

TEST_F(GraphSetTest, ReadsAGraphWhenItIsAskedFor) {
  const auto set = GraphSet::open(folder_);
  EXPECT_EQ(set->size(), 2U);
  EXPECT_EQ(set->graph("one").size(), 4U);
  EXPECT_EQ(&set->graph("one"), &set->graph(ScanIndex(0)));
  EXPECT_THROW(set->graph("two"), FileError);
  write_file_atomically(folder_ / "two_connectivity.json", to_json(testing::square("two")));
  EXPECT_EQ(set->graph("two").size(), 4U) << "a failed read is tried again";
}

TEST_F(GraphSetTest, NamesWhatIsUnknown) {
  const auto set = GraphSet::open(folder_);
  EXPECT_THAT([&] { set->at("three"); },
              ThrowsMessage<LookupError>(HasSubstr("\"three\" is not one of the 2 scans")));
  EXPECT_THAT([&] { set->locate("one", "v9"); },
              ThrowsMessage<LookupError>(HasSubstr("\"v9\" is not one of the 4 of scan one")));
  EXPECT_EQ(set->locate("one", "v2"), (Location{ScanIndex(0), ViewpointIndex(2)}));
}

TEST_F(GraphSetTest, RefusesAnExcludedViewpoint) {
  scan::Connectivity c = testing::square("two");
  c.entries[3].included = false;
  std::vector<NavGraph> graphs;
  graphs.emplace_back(c);
  EXPECT_THAT([set = GraphSet::of(std::move(graphs))] { set->locate("two", "v3"); },
              ThrowsMessage<LookupError>(HasSubstr("is excluded")));
}

TEST_F(GraphSetTest, OneFolderIsSharedAsLongAsSomebodyHoldsIt) {
  const auto set = GraphSet::open_shared(folder_);
  EXPECT_EQ(GraphSet::open_shared(folder_ / "." / "").get(), set.get());
  EXPECT_NE(GraphSet::open(folder_).get(), set.get());
}

TEST_F(GraphSetTest, ManyThreadsGetOneGraph) {
  const auto set = GraphSet::open(folder_);
  std::array<std::atomic<const NavGraph*>, 4> seen{};
  {
    std::vector<std::jthread> threads;
    for (auto& slot : seen) threads.emplace_back([&] { slot = &set->graph("one"); });
  }
  for (const auto& slot : seen) EXPECT_EQ(slot.load(), seen[0].load());
}

TEST(GraphSet, OfRefusesTwoOfOneName) {
  std::vector<NavGraph> graphs;
  graphs.emplace_back(testing::square("a"));
  graphs.emplace_back(testing::square("a"));
  EXPECT_THROW(GraphSet::of(std::move(graphs)), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::graph
