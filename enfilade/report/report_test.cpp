#include "enfilade/report/report.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/mesh/house.h"
#include "enfilade/report/parts/page.h"
#include "enfilade/report/parts/parts.h"
#include "enfilade/scan/store.h"
#include "tests/support/made_run.h"
#include "tests/support/page.h"

namespace enfilade::report {
namespace EN_UNIT {

namespace fs = std::filesystem;
using testing::data_of;
using testing::decoded;
using testing::find_browser;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::occurrences;
using testing::open_in_browser;
using ::testing::ThrowsMessage;

// What a page that takes an instruction for HTML would run, or show as a picture.
constexpr const char* kHostile =
    "</script><script>document.title='hacked'</script><img src=x "
    "onerror=\"document.title='hacked'\">"
    "<!--<script> turn \u00e9 {{title}}";

class ReportTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (parts::kD3.empty()) GTEST_SKIP() << "this build has no D3 (EN_WITH_D3 is OFF)";
  }
  std::string report() const {
    ReportConfig config;
    config.runs = {made_.run()};
    config.title = "A <test> of reports";
    config.facts = {{"machine", "one & <only>"}};
    return make_report(config, dataset::Dataset(made_.data()));
  }
  // Everything that a page can show, from strangers.
  void make_all() const {
    for (const char* split : {"train", "val_seen", "val_unseen"}) {
      made_.write_split(split, false, kHostile);
    }
    made_.write_pictures();
    for (const char* split : {"val_seen", "val_unseen"}) {
      made_.write_results(made_.run() / "results" / fmt::format("random_{}.json", split), 1);
      made_.write_results(made_.run() / "results" / fmt::format("shortest_{}.json", split), 4);
    }
    made_.write_model("student-1", 0);
    made_.write_model("student-2", 0.1);
    made_.write_attention("student-2", "val_unseen", "</script><b>walk");
    made_.write_attention("student-1", "val_unseen", "</script><b>walk");
  }
  testing::MadeRun made_;
};

TEST_F(ReportTest, HasEveryPart) {
  make_all();
  const nlohmann::json data = data_of(report());
  for (const char* part : {"table", "curves", "errors", "byLength", "gallery", "plans", "examples",
                           "panoramas", "lengths", "words", "about"}) {
    ASSERT_TRUE(data.contains(part)) << part;
    EXPECT_FALSE(data[part].contains("missing")) << part << ": " << data[part].dump();
  }
  EXPECT_EQ(data["table"]["rows"].size(), 6U) << "three agents on two splits";
  EXPECT_EQ(data["curves"]["agents"][0]["runs"].size(), 2U) << "two seeds of one agent";
  EXPECT_EQ(data["panoramas"]["panoramas"].size(), 1U);
  EXPECT_EQ(data["examples"]["paths"][0]["instructions"].size(), 3U);
  EXPECT_THAT(data["examples"]["paths"][0]["picture"].get<std::string>(),
              ::testing::StartsWith("data:image/jpeg;base64,"));
}

TEST_F(ReportTest, GalleryIsOfTheModelWithItsAttention) {
  make_all();
  const nlohmann::json gallery = data_of(report())["gallery"];
  EXPECT_EQ(gallery["agent"], "student-1");
  EXPECT_EQ(gallery["split"], "val_unseen");
  ASSERT_EQ(gallery["episodes"].size(), 1U) << "attention was kept for one path only";
  const nlohmann::json& episode = gallery["episodes"][0];
  EXPECT_EQ(episode["kind"], "worst") << "two moves from v0 end 4 m before v4";
  EXPECT_EQ(episode["error"], 4);
  ASSERT_EQ(episode["steps"].size(), 3U);
  EXPECT_EQ(episode["steps"][1]["attention"][1], 0.8);
  EXPECT_TRUE(gallery["frames"].contains(episode["steps"][1]["frame"].get<std::string>()));
  EXPECT_EQ(gallery["frames"].size(), 3U) << "three poses, each drawn once";
}

TEST_F(ReportTest, WithoutAttentionStepsAreThoseOfTheResultsFile) {
  made_.write_results(made_.run() / "random_val_unseen.json", 2);
  const nlohmann::json gallery = data_of(report())["gallery"];
  EXPECT_THAT(gallery["noAttention"].get<std::string>(), HasSubstr("attention.json"));
  EXPECT_THAT(gallery["noPictures"].get<std::string>(), HasSubstr("row"));
  ASSERT_EQ(gallery["episodes"].size(), 2U) << "of each path once";
  EXPECT_EQ(gallery["episodes"][0]["kind"], "best") << "2 m before v3";
  EXPECT_EQ(gallery["episodes"][1]["kind"], "worst") << "4 m before v4";
  EXPECT_EQ(gallery["episodes"][0]["steps"][0]["action"], "forward");
  EXPECT_EQ(gallery["episodes"][0]["steps"][2]["action"], "end");
}

TEST_F(ReportTest, SaysWhyAPartIsLeftOut) {
  made_.write_results(made_.run() / "shortest_val_unseen.json", 3);
  const nlohmann::json data = data_of(report());
  EXPECT_THAT(data["curves"]["missing"].get<std::string>(), HasSubstr("No model"));
  EXPECT_THAT(data["errors"]["missing"].get<std::string>(), HasSubstr("Shortest"));
  EXPECT_THAT(data["panoramas"]["missing"].get<std::string>(), HasSubstr("no pictures"));
}

// As `graph draw` and the pages draw them, from the same file.
TEST_F(ReportTest, PlansAndMapsHaveTheWallsOfTheBuilding) {
  make_all();
  const nlohmann::json before = data_of(report());
  EXPECT_TRUE(before["gallery"]["buildings"]["row"]["plan"].empty());
  EXPECT_THAT(decoded(before["plans"]["plans"][0]["picture"].get<std::string>()),
              Not(HasSubstr(">wall<")));
  mesh::House house;
  house.name = "row";
  house.levels.push_back({"-", {}, {{-1, -2, 0}, {9, 2, 3}}});
  house.regions.push_back({0, 'k', {}, {{-1, -2, 0}, {9, 2, 2.5}}, 2.5});
  house.categories.push_back({0, "table", 5, "table"});
  house.objects.push_back({0, 0, {3, 1, 0.4}, {0, 1, 0}, {-1, 0, 0}, {0.8, 0.5, 0.4}});
  const fs::path folder = made_.data() / "v1/scans/row/house_segmentations";
  make_folder(folder);
  write_file_atomically(folder / "row.house", mesh::to_text(house));
  const nlohmann::json data = data_of(report());
  const nlohmann::json& plan = data["gallery"]["buildings"]["row"]["plan"];
  ASSERT_EQ(plan.size(), 1U) << "a storey";
  EXPECT_EQ(plan[0]["lines"]["walls"].size(), 16U) << "four walls of four numbers";
  EXPECT_EQ(plan[0]["lines"]["furniture"].size(), 16U);
  EXPECT_EQ(plan[0]["names"], nlohmann::json::parse(R"([["kitchen", 4, 0]])"));
  const std::string svg = decoded(data["plans"]["plans"][0]["picture"].get<std::string>());
  for (const char* text : {">wall<", ">furniture<", ">kitchen<"}) {
    EXPECT_THAT(svg, HasSubstr(text));
  }
}

// Homes for training have faces of 64 texels; a page shows those of display quality.
TEST_F(ReportTest, PicturesAreOfBuildingsWithEnoughTexels) {
  make_all();
  const scan::Connectivity wing = scan::testing::row_of_viewpoints("wing", 2);
  write_file_atomically(made_.data() / "connectivity/scans.txt", "row\nwing\n");
  write_file_atomically(made_.data() / "connectivity/wing_connectivity.json", to_json(wing));
  const auto shown = [this] {
    const dataset::Dataset data(made_.data());
    return parts::panoramas_part(data, 16);
  };
  EXPECT_EQ(shown()["panoramas"].size(), 1U) << "of row, with 32 texels: better than none";
  EXPECT_FALSE(shown().contains("leastTexels"));
  std::vector<scan::Panorama> panoramas;
  for (std::uint64_t v = 0; v < 2; ++v) {
    panoramas.push_back(scan::testing::panorama(parts::kClearTexels, v));
  }
  scan::pack(scan::MemoryPanoramas(wing, std::move(panoramas)), made_.data() / "store", {});
  const parts::Json clear = shown();
  ASSERT_EQ(clear["panoramas"].size(), 1U);
  EXPECT_EQ(clear["panoramas"][0]["scan"], "wing");
  EXPECT_EQ(clear["leastTexels"], 256);
  EXPECT_EQ(clear["buildings"], 2);
  const dataset::Dataset data(made_.data());
  EXPECT_EQ(parts::clear_scans(data), std::set<ScanIndex>{data.graphs()->at("wing")});
}

TEST_F(ReportTest, LoadsNothingAndRunsNoScriptButItsOwn) {
  make_all();
  const std::string page = report();
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
  for (const char* source : {"src=\"http", "src=\"//", "href=\"http", "url(http", "@import",
                             "<link", "<iframe", "fetch(", "XMLHttpRequest("}) {
    const std::size_t in_d3 = occurrences(std::string(parts::kD3), source);
    EXPECT_EQ(occurrences(page, source), in_d3) << source << " (D3 has code for it, unused)";
  }
  EXPECT_EQ(occurrences(page, "<script"), 3U) << "data, D3 and ours";
  EXPECT_EQ(occurrences(page, "</script"), 3U);
  EXPECT_THAT(page, Not(HasSubstr("<img src=x")));
  EXPECT_THAT(page, HasSubstr("<title>A &lt;test&gt; of reports</title>"));
}

TEST_F(ReportTest, IsTheSameForTheSameInputButForItsNonce) {
  make_all();
  EXPECT_EQ(data_of(report()), data_of(report()));
}

TEST(Page, ScriptJsonHasNoTagsAndReadsBackEqual) {
  const nlohmann::ordered_json data{{"a", "</script><!-- \u2028 \xC3\xA9"}, {"b<", 1}};
  const std::string json = parts::script_json(data);
  EXPECT_EQ(json.find('<'), std::string::npos);
  EXPECT_EQ(nlohmann::ordered_json::parse(json), data);
  EXPECT_THAT(parts::script_json({{"a", "\xFF"}}), HasSubstr("\\ufffd"));
}

TEST(Page, D3HasNoEndOfScriptInIt) {
  EXPECT_EQ(parts::kD3.find("</script"), std::string_view::npos);
  EXPECT_EQ(parts::kPageScript.find("</script"), std::string_view::npos);
  EXPECT_EQ(parts::kPageScript.find("innerHTML"), std::string_view::npos);
}

TEST(DataUri, IsBase64AsRfc4648HasIt) {
  EXPECT_EQ(parts::data_uri("text/plain", ""), "data:text/plain;base64,");
  EXPECT_EQ(parts::data_uri("t", "f"), "data:t;base64,Zg==");
  EXPECT_EQ(parts::data_uri("t", "fo"), "data:t;base64,Zm8=");
  EXPECT_EQ(parts::data_uri("t", "foobar"), "data:t;base64,Zm9vYmFy");
  EXPECT_EQ(parts::data_uri("t", "\xFF\xFE\xFD"), "data:t;base64,//79");
}

TEST(WilsonInterval, HasTheTextbooksValues) {
  // Share 0: (0, z^2 / (n + z^2)); n = 10: 3.8415 / 13.8415 = 0.2775.
  EXPECT_EQ(parts::wilson_interval(0, 10).low, 0);
  EXPECT_NEAR(parts::wilson_interval(0, 10).high, 0.2775, 1e-4) << "four digits worked out";
  EXPECT_NEAR(parts::wilson_interval(0.5, 10).low, 0.2366, 1e-4);
  EXPECT_NEAR(parts::wilson_interval(0.5, 10).high, 0.7634, 1e-4);
}

// --- in a real browser ----------------------------------------------------------------------

class BrowserTest : public ReportTest {
 protected:
  void SetUp() override {
    ReportTest::SetUp();
    browser_ = find_browser();
    if (!browser_) GTEST_SKIP() << "no browser: chromium is not installed";
  }
  std::string open(const std::string& html) const {
    const fs::path page = made_.run() / "page.html";
    write_file_atomically(page, html);
    return open_in_browser(*browser_, page);
  }
  std::optional<std::string> browser_;
};

TEST_F(BrowserTest, DrawsEveryPartAndRunsNothingElse) {
  make_all();
  const std::string dom = open(report());
  EXPECT_THAT(dom, HasSubstr("data-ready=\"yes\""));
  EXPECT_THAT(dom, Not(HasSubstr("data-failures"))) << dom.substr(dom.find("id=\"failures\""), 500);
  EXPECT_THAT(dom, HasSubstr("<title>A &lt;test&gt; of reports</title>"));
  EXPECT_THAT(dom, Not(HasSubstr("hacked</title>")));
  for (const auto& [mark, least] : std::vector<std::pair<std::string, std::size_t>>{
           {"<svg", 12},                          // charts, legends, map, heat map, sunburst
           {"class=\"line split-seen\"", 4},      // curves, histograms
           {"class=\"line split-unseen\"", 4},    //
           {"class=\"line one-seed split-", 12},  // two seeds, three splits, three curves, no train
           {"class=\"cell\"", 9},                 // three steps of three words
           {"class=\"here\"", 1},                 // the agent on its map
           {"data:image/jpeg", 5},                // frames, example, panorama
           {"data:image/svg+xml", 1}}) {          // floor plan
    EXPECT_GE(occurrences(dom, mark), least) << mark;
  }
  EXPECT_THAT(dom, HasSubstr("fewer than 5 of each length")) << "two paths are too few";
}

TEST_F(BrowserTest, DrawsWhatThereIsWithoutModelsAndPictures) {
  made_.write_results(made_.run() / "random_val_unseen.json", 2);
  const std::string dom = open(report());
  EXPECT_THAT(dom, HasSubstr("data-ready=\"yes\""));
  EXPECT_THAT(dom, Not(HasSubstr("data-failures"))) << dom.substr(dom.find("id=\"failures\""), 500);
  EXPECT_EQ(occurrences(dom, "class=\"missing\""), 1U) << "one line for all that is left out";
  EXPECT_THAT(dom, HasSubstr("Training, Settings: No model was trained here."));
  for (const char* section : {"training", "buildings", "settings", "length"}) {
    EXPECT_THAT(dom, Not(HasSubstr(fmt::format("<section id=\"{}\"", section))));
    EXPECT_THAT(dom, Not(HasSubstr(fmt::format("href=\"#{}\"", section)))) << "nor in the contents";
  }
  EXPECT_THAT(dom, HasSubstr("<section id=\"results\""));
}

TEST_F(BrowserTest, AFailureIsSeen) {
  made_.write_results(made_.run() / "random_val_unseen.json", 2);
  std::string page = report();
  const std::size_t at = page.find("\"curves\":");
  ASSERT_NE(at, std::string::npos);
  page.insert(at, "\"curves\":{},\"was\":0,");
  page.replace(page.find("\"curves\":", at + 12), 8, "\"unused\"");  // the part has nothing in it
  EXPECT_THAT(open(page), HasSubstr("data-failures=\"1\""));
}

TEST(TrainingCurve, KeepsTheMeanAndTheNumberOfPoints) {
  std::vector<models::TrainRecord> records;
  for (std::uint64_t i = 0; i < 1000; ++i) records.push_back({i, i % 2 == 0 ? 1.0 : 3.0});
  const auto curve = parts::training_curve(records, 400);
  EXPECT_EQ(curve.size(), 334U) << "three at a time, one left";
  EXPECT_EQ(curve[0].iteration, 1);
  EXPECT_NEAR(curve[0].loss, 5.0 / 3, 1e-12) << "(1 + 3 + 1) / 3, rounding aside";
  EXPECT_EQ(curve.back().iteration, 999);
  EXPECT_EQ(parts::training_curve(records, 1000).size(), 1000U);
}

}  // namespace EN_UNIT
}  // namespace enfilade::report
