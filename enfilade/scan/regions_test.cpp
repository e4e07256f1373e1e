#include "enfilade/scan/regions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/core/errors.h"
#include "enfilade/scan/data_root.h"

namespace enfilade::scan {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(RegionMap, FindsTheRegionOfAViewpoint) {
  const RegionMap map = RegionMap::parse(R"({"s": {"0": ["a", "b"], "7": ["c"]}, "r": {}})", "f");
  EXPECT_EQ(map.find("s", "b"), 0U);
  EXPECT_EQ(map.find("s", "c"), 7U);
  EXPECT_EQ(map.find("s", "d"), std::nullopt);
  EXPECT_EQ(map.find("t", "a"), std::nullopt);
  EXPECT_THAT(map.scans(), ElementsAre("r", "s"));
  EXPECT_EQ(map.regions(), 2U);
}

TEST(RegionMap, RefusesWhatIsNoMap) {
  const auto parse = [](const char* text) { return [text] { RegionMap::parse(text, "f"); }; };
  EXPECT_THAT(parse("[]"), ThrowsMessage<InvalidInput>(HasSubstr("$: array of 0, not an object")));
  EXPECT_THAT(parse(R"({"s": []})"), ThrowsMessage<InvalidInput>(HasSubstr("$.s: array")));
  EXPECT_THAT(parse(R"({"s": {"-1": []}})"),
              ThrowsMessage<InvalidInput>(HasSubstr("region \"-1\", not a whole number")));
  EXPECT_THAT(parse(R"({"s": {"1": [2]}})"),
              ThrowsMessage<InvalidInput>(HasSubstr("$.s.1[0]: number 2, not a string")));
  EXPECT_THAT(parse(R"({"s": {"1": ["a"], "2": ["a"]}})"),
              ThrowsMessage<InvalidInput>(HasSubstr("\"a\" is in region 1 already")));
}

TEST(RegionsToJson, WritesALineAScanAndIsReadBack) {
  const std::string json = to_json(
      std::vector<ScanRegions>{{"s", {{"a", "b"}, {}, {"c"}}}, {"r", {{}}}, {"t.1", {{"a-b"}}}});
  EXPECT_EQ(json,
            "{\n\"s\": {\"0\": [\"a\", \"b\"], \"2\": [\"c\"]},\n\"r\": {},\n"
            "\"t.1\": {\"0\": [\"a-b\"]}\n}\n");
  const RegionMap map = RegionMap::parse(json, "f");
  EXPECT_THAT(map.scans(), ElementsAre("r", "s", "t.1"));
  EXPECT_EQ(map.find("s", "b"), 0U);
  EXPECT_EQ(map.find("s", "c"), 2U);
  EXPECT_EQ(map.find("t.1", "a-b"), 0U);
  EXPECT_TRUE(RegionMap::parse(to_json(std::vector<ScanRegions>{}), "f").scans().empty());
}

TEST(RegionMap, ReadsTheRealMap) {
  const auto data = DataRoot::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set: no real region map";
  const RegionMap map = RegionMap::load(data->regions());
  EXPECT_EQ(map.scans().size(), 90U);
  EXPECT_EQ(map.regions(), 1982U);
  const auto region = map.find("17DRP5sb8fy", "8ccf449f599a4cd88648e1d0ff39fdd0");
  EXPECT_EQ(region, map.find("17DRP5sb8fy", "cb66d4266148455bbddf5d059a483711"));
  EXPECT_NE(region, map.find("17DRP5sb8fy", "db145474a5fa476d95c2cc7f09e7c83a"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::scan
