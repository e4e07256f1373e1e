#include "enfilade/arena/words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "enfilade/arena/world.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/mesh/mpcat40.h"
#include "enfilade/scan/store.h"
#include "tests/support/panoramas.h"
#include "tests/support/refusal.h"
#include "tests/support/room_world.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::arena {
namespace EN_UNIT {

using ::testing::HasSubstr;

/// Says where it was asked, so that a test sees what is asked for, and how often.
class Recorder : public Words {
 public:
  explicit Recorder(std::vector<Standpoint>& asked) : asked_(asked) {}
  std::string of(const Standpoint& from) override {
    asked_.push_back(from);
    return "view " + std::to_string(asked_.size());
  }

 private:
  std::vector<Standpoint>& asked_;
};

class WordsTest : public ::testing::Test {
 protected:
  /// Three viewpoints in a row, to the east, whose panoramas are label_cube().
  WordsTest() : folder_("words") {
    for (const char* name : {"connectivity", "r2r", "store"}) make_folder(folder_.path() / name);
    const scan::Connectivity row = scan::testing::row_of_viewpoints("row", 3);
    write_file_atomically(folder_.path() / "connectivity/scans.txt", "row\n");
    write_file_atomically(folder_.path() / "connectivity/row_connectivity.json",
                          scan::to_json(row));
    std::vector<scan::Panorama> panoramas(3, label_cube());
    scan::pack(scan::MemoryPanoramas(row, std::move(panoramas)), folder_.path() / "store", {});
    tasks::Annotations split{"val_seen", "", {}};
    split.paths.push_back({1, "row", degrees(90), {"v1", "v2"}, 1.0, {"Go on."}});
    write_file_atomically(folder_.path() / "r2r/R2R_val_seen.json", to_json(split));
  }

  /// Walls; but a face for which `is_named` is a bed (object 5) above, and below two chairs side by
  /// side (objects 6 and 7) with a lamp between them that is too small to be told.
  static scan::Panorama label_cube() {
    scan::Panorama p = scan::make_panorama(kFace);
    for (std::size_t k = 0; k < kCubeFaces; ++k) {
      for (std::size_t y = 0; y < kFace; ++y) {
        for (std::size_t x = 0; x < kFace; ++x) {
          const bool upper = y < kFace / 2, left = x < kFace / 2;
          const bool lamp = !upper && x == kFace / 2 && y == kFace / 2;
          std::uint16_t category = mesh::Mpcat40::kWall;
          std::uint32_t object = 1;
          if (k != kBareFace) {
            category = lamp    ? mesh::Mpcat40::kLighting
                       : upper ? mesh::Mpcat40::kBed
                               : mesh::Mpcat40::kChair;
            object = lamp ? 8 : upper ? 5 : left ? 6 : 7;
          }
          *p.classes[k].at(x, y) = category;
          *p.instances[k].at(x, y) = object;
        }
      }
    }
    return p;
  }
  static constexpr std::uint32_t kFace = 64;
  static constexpr std::size_t kBareFace = 4;

  tests::TemporaryFolder folder_;
  std::vector<Standpoint> asked_;
};

TEST_F(WordsTest, LabelsAreCountedAndTheLargestComesFirst) {
  const auto data = std::make_shared<const dataset::Dataset>(folder_.path());
  const auto words = label_words({.data = data})();
  std::map<std::string, int> said;
  for (const double heading : {0.0, 90.0, 180.0, 270.0}) {
    ++said[words->of({"row", "v1", graph::Location{ScanIndex(0), ViewpointIndex(1)},
                      degrees(heading), degrees(10)})];
  }
  // A little above the horizon the bed takes more than half of the view; one side is bare.
  EXPECT_EQ(said["bed, chair (2)"], 3) << ::testing::PrintToString(said);
  EXPECT_EQ(said[""], 1);
}

/// Says what it was asked; the first time it refuses.
class Captioner : public Endpoint {
 public:
  std::string post(std::string_view body, const RequestOrigin& origin) override {
    bodies.emplace_back(body);
    origins.push_back(origin.episode);
    if (bodies.size() == 1) throw EndpointError(status, refusal, {}, refusal);
    const nlohmann::json message{{"role", "assistant"}, {"content", text}};
    return nlohmann::json{{"choices", {{{"index", 0}, {"message", message}}}}}.dump();
  }
  int status = 503;
  std::string refusal = "out of order";
  std::string text = " A bed,\n\n<b>two</b> chairs. ";
  std::vector<std::string> bodies, origins;
};

TEST_F(WordsTest, CaptionsAreAskedForOnceAndKept) {
  const auto data = std::make_shared<const dataset::Dataset>(folder_.path());
  Captioner captioner;
  AnswerCache cache(folder_.path() / "cache");
  const CaptionConfig config{.chat = {.model = "m"}, .picture_size = 64, .first_wait = 0.001};
  const auto words = caption_words({.data = data}, config, &captioner, cache)();
  const Standpoint from{"row", "v1", graph::Location{ScanIndex(0), ViewpointIndex(1)}, degrees(90),
                        Radians(0)};
  EXPECT_EQ(words->of(from), "A bed, <b>two</b> chairs.");
  ASSERT_EQ(captioner.bodies.size(), 2U) << "once more after 503";
  EXPECT_EQ(captioner.origins[1], "caption/view/row/v1/90.0000/0.0000/64");
  const auto asked = nlohmann::json::parse(captioner.bodies[1]);
  EXPECT_EQ(asked.at("model"), "m");
  const auto& content = asked.at("messages").at(0).at("content");
  EXPECT_THAT(content.at(0).at("text").get<std::string>(), HasSubstr("one short sentence"));
  EXPECT_THAT(content.at(1).at("image_url").at("url").get<std::string>(),
              ::testing::StartsWith("data:image/jpeg;base64,/9j/"));
  // Another thread's, another day: nobody is asked.
  EXPECT_EQ(caption_words({.data = data}, config, nullptr, cache)()->of(from),
            "A bed, <b>two</b> chairs.");
  Standpoint other = from;
  other.heading = degrees(91);
  EXPECT_THAT(
      tests::refusal<Error>([&] { caption_words({}, config, nullptr, cache)()->of(other); }),
      HasSubstr("is not in the cache"));
  captioner.text = std::string(299, 'a') + "\xC3\xA9 is long";
  EXPECT_EQ(words->of(other), std::string(299, 'a')) << "no half of a character";
}

TEST_F(WordsTest, CaptionersRefuseLikeModels) {
  const auto data = std::make_shared<const dataset::Dataset>(folder_.path());
  const Standpoint from{"row", "v1", graph::Location{ScanIndex(0), ViewpointIndex(1)}, degrees(90),
                        Radians(0)};
  const CaptionConfig config{.chat = {.model = "m", .most_tokens = 50},
                             .limit = LimitField::kMaxCompletionTokens,
                             .picture_size = 64};
  struct Row {
    const char *refusal, *caption;
    std::size_t requests;
  };
  constexpr Row kRows[] = {
      {R"({"error": {"message": "temperature: only 1 is supported"}})", "A bed.", 2},
      {R"({"error": {"code": "content_filter"}})", "", 1},
  };
  for (const Row& row : kRows) {
    AnswerCache cache(folder_.path() / ("cache" + std::to_string(row.requests)));
    Captioner captioner;
    captioner.status = 400;
    captioner.refusal = row.refusal;
    captioner.text = "A bed.";
    EXPECT_EQ(caption_words({.data = data}, config, &captioner, cache)()->of(from), row.caption);
    ASSERT_EQ(captioner.bodies.size(), row.requests);
    const auto first = nlohmann::json::parse(captioner.bodies.front());
    EXPECT_TRUE(first.contains("temperature"));
    EXPECT_EQ(first.at("max_completion_tokens"), 50);
    const auto last = nlohmann::json::parse(captioner.bodies.back());
    EXPECT_EQ(last.contains("temperature"), row.requests == 1);
    EXPECT_EQ(caption_words({.data = data}, config, nullptr, cache)()->of(from), row.caption);
  }
}

TEST_F(WordsTest, EachPlaceHasThoseOfItsDirection) {
  const dataset::Dataset data(folder_.path());
  GraphWorld world(std::make_shared<const tasks::EpisodeSet>(data.episodes("val_seen")),
                   [this] { return std::make_unique<Recorder>(asked_); });
  const auto session = world.start(0);
  ASSERT_EQ(asked_.size(), 2U);
  for (std::size_t k = 0; k < 2; ++k) {
    const Neighbour& place = session->observation().places[k];
    EXPECT_EQ(place.what, "view " + std::to_string(k + 1));
    EXPECT_NEAR(wrap_difference(asked_[k].heading - degrees(90) - place.turn).value, 0, 1e-9);
    EXPECT_EQ(asked_[k].place, "v1");
  }
  session->call({"look", "left"});
  EXPECT_EQ(asked_.size(), 2U) << "the same directions, although one looks elsewhere";
  session->call({"look", "right"});
  EXPECT_EQ(session->observation().places[0].what, "view 1");
}

TEST(FloorWords, SayWhatIsAhead) {
  std::vector<Standpoint> asked;
  const FloorWorld silent = testing::room();
  FloorWorld world(silent.episodes(), silent.buildings(),
                   [&asked] { return std::make_unique<Recorder>(asked); });
  const auto session = world.start(0);
  EXPECT_EQ(session->observation().what, "view 1");
  session->call({"move", "left"});
  EXPECT_EQ(session->observation().what, "view 2");
  EXPECT_NEAR(to_degrees(asked[1].heading), 75, 1e-6);
}

TEST(FloorWords, LabelsNameWhatTheMeshHas) {
  // A room whose walls have no class: nothing to name.
  const Standpoint from{"room", "1/1/1", Vec3d{1, 1, 1.25}, degrees(90), Radians(0)};
  const auto words = label_words({.data = nullptr, .scene_of = [](const std::string&) {
                                    return continuous::Scene::photographed(testing::room_tracer());
                                  }})();
  EXPECT_EQ(words->of(from), "");
  const auto blind = label_words({})();
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { blind->of(from); }), HasSubstr("no meshes"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::arena
