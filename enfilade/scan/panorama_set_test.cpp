#include "enfilade/scan/panorama_set.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <filesystem>
#include <thread>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/scan/store.h"
#include "tests/support/panoramas.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::scan {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using tests::TemporaryFolder;

TEST(PanoramaSet, HoldsSourcesInTheOrderGiven) {
  const auto b = testing::memory_panoramas("b", 1, 2);
  const auto a = testing::memory_panoramas("a", 2, 2);
  const auto set = PanoramaSet::of({b, a});
  EXPECT_EQ(set->scans(), (std::vector<std::string>{"b", "a"}));
  EXPECT_EQ(set->find("a"), ScanIndex(1));
  EXPECT_EQ(set->find("c"), std::nullopt);
  EXPECT_EQ(&set->source(ScanIndex(1)), a.get());
  EXPECT_THAT([&] { set->at("c"); }, ThrowsMessage<LookupError>(HasSubstr("\"c\"")));
}

TEST(PanoramaSet, RefusesNullAndRepeatedScans) {
  const auto a = testing::memory_panoramas("a", 1, 2);
  EXPECT_THROW(PanoramaSet::of({a, nullptr}), ArgumentError);
  EXPECT_THROW(PanoramaSet::of({a, a}), ArgumentError);
  EXPECT_THROW(PanoramaSet::open({}, {"a", "b", "a"}), ArgumentError);
}

TEST(PanoramaSet, NamesEveryPlaceThatWasTried) {
  const TemporaryFolder first("panorama_set_first"), second("panorama_set_second");
  const auto set = PanoramaSet::open({{first.path(), second.path()}, first.path()}, {"absent"});
  EXPECT_THAT([&] { set->source(ScanIndex(0)); },
              ThrowsMessage<LookupError>(AllOf(
                  HasSubstr("\"absent\""), HasSubstr((first.path() / "absent.enfilade").string()),
                  HasSubstr((second.path() / "absent.enfilade").string()),
                  HasSubstr("matterport_skybox_images"))));
  EXPECT_THAT([] { open_panoramas({}, "absent"); },
              ThrowsMessage<LookupError>(HasSubstr("no folder")));
  EXPECT_THROW(open_panoramas({{first.path()}, {}}, "../absent"), LookupError);
}

TEST(PanoramaSet, OpensAStoreOnceForAllThreads) {
  const TemporaryFolder folder("panorama_set_store");
  pack(*testing::memory_panoramas("a", 2, 8), folder.path(), {});
  const auto set = PanoramaSet::open({{folder.path()}, {}}, {"a"});
  std::vector<const PanoramaSource*> seen(4);
  std::vector<std::thread> threads;
  for (auto& one : seen) threads.emplace_back([&] { one = &set->source(ScanIndex(0)); });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(seen, std::vector<const PanoramaSource*>(4, seen[0]));
  EXPECT_EQ(seen[0]->origin(), store_file(folder.path(), "a").string());
}

TEST(PanoramaSet, TriesAgainAfterAFailure) {
  const TemporaryFolder folder("panorama_set_again");
  const auto set = PanoramaSet::open({{folder.path()}, {}}, {"a"});
  EXPECT_THROW(set->source(ScanIndex(0)), LookupError);
  write_file_atomically(store_file(folder.path(), "a"), "not a store");
  EXPECT_THROW(set->source(ScanIndex(0)), InvalidInput);
  fs::remove(store_file(folder.path(), "a"));
  pack(*testing::memory_panoramas("a", 1, 8), folder.path(), {});
  EXPECT_EQ(set->source(ScanIndex(0)).size(), 1U);
}

}  // namespace EN_UNIT
}  // namespace enfilade::scan
