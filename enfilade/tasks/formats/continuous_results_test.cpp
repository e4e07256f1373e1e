#include "enfilade/tasks/continuous_results.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "enfilade/scan/data_root.h"
#include "enfilade/tasks/continuous_score.h"
#include "tests/support/refusal.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using Json = nlohmann::json;

// Two episodes that start at Habitat's (1, 0, 2): ours (1, -2, 0).
ContinuousEpisodes two_episodes() {
  ContinuousEpisodes episodes{"made", "made.json", {}};
  for (const int id : {7, 9}) {
    ContinuousEpisode one;
    one.id = id;
    one.scene = "mp3d/one/one.glb";
    one.start = {1, -2, 0};
    one.instruction.id = std::to_string(100 - id);
    episodes.episodes.push_back(one);
  }
  return episodes;
}

// Left by 0.25, a step, a step against a wall, stop; an agent that never moves.
const std::string kR2r = R"({"9": [{"position": [1, 0, 2], "heading": 0, "stop": false}], )"
                         R"("7": [{"position": [1, 0, 2], "heading": 0, "stop": false}, )"
                         R"({"position": [1, 0, 2], "heading": 0.25, "stop": false}, )"
                         R"({"position": [1, 0.5, 1.75], "heading": 0.25, "stop": false}, )"
                         R"({"position": [1, 0.5, 1.75], "heading": 0.25, "stop": false}, )"
                         R"({"position": [1, 0.5, 1.75], "heading": 0.25, "stop": true}]})";
const std::string kRxr = R"({"instruction_id": "93", "path": [[1, 0, 2], [1, 0.5, 1.75]]})"
                         "\n"
                         R"({"instruction_id": "91", "path": [[1, 0, 2]]})"
                         "\n";

std::vector<ContinuousResult> parsed(const std::string& text, Coverage coverage = Coverage::kAll) {
  return parse_continuous_results(text, "r.json", two_episodes(), coverage);
}

std::string edited(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string faults(const std::string& text) {
  return tests::refusal<InvalidInput>([&] { parsed(text); });
}

TEST(ContinuousResults, AreReadInTheOrderOfTheEpisodes) {
  const auto walks = parsed(kR2r);
  ASSERT_THAT(walks, SizeIs(2));
  const ContinuousResult& first = walks[0];
  EXPECT_EQ(first.episode, 0U);
  EXPECT_THAT(first.positions, ElementsAre(Vec3f{1, -2, 0}, Vec3f{1, -2, 0}, Vec3f{1, -1.75, 0.5},
                                           Vec3f{1, -1.75, 0.5}, Vec3f{1, -1.75, 0.5}));
  EXPECT_EQ(first.headings[0], Radians(0));
  EXPECT_NEAR(first.headings[1].value, 2 * kPi - 0.25, 1e-15);
  EXPECT_THAT(first.actions, ElementsAre(2, 1, 1, 0));
  EXPECT_THAT(first.collided, IsEmpty());
  EXPECT_TRUE(first.stopped());
  EXPECT_THAT(walks[1].positions, SizeIs(1));
  EXPECT_THAT(walks[1].actions, IsEmpty());
  EXPECT_FALSE(walks[1].stopped());
}

TEST(ContinuousResults, AreReadFromRxrsLines) {
  const auto walks = parsed(kRxr);
  ASSERT_THAT(walks, SizeIs(2));
  EXPECT_THAT(walks[0].positions,
              ElementsAre(Vec3f{1, -2, 0}, Vec3f{1, -1.75, 0.5}, Vec3f{1, -1.75, 0.5}));
  EXPECT_THAT(walks[0].actions, ElementsAre(1, 0));
  EXPECT_THAT(walks[0].headings, IsEmpty());
  EXPECT_THAT(walks[1].actions, ElementsAre(0));
}

TEST(ContinuousResults, AreWrittenBackEqual) {
  const auto walks = parsed(kR2r);
  const std::string text = to_json(walks, two_episodes(), ContinuousForm::kR2r);
  EXPECT_EQ(Json::parse(text), Json::parse(kR2r));
  EXPECT_EQ(parsed(text), walks);
  const std::string lines = to_json(walks, two_episodes(), ContinuousForm::kRxr);
  EXPECT_EQ(parsed(lines), parsed(kRxr));
  EXPECT_TRUE(lines.starts_with("{\"instruction_id\":\"91\"")) << lines;
}

TEST(ContinuousResults, MayBeAPartOfASplit) {
  const std::string one = R"({"9": [{"position": [1, 0, 2], "heading": 0, "stop": false}]})";
  EXPECT_THAT(faults(one), HasSubstr("$: no walk for 1 of the 2 episodes of split made: \"7\""));
  const auto walks = parsed(one, Coverage::kPart);
  ASSERT_THAT(walks, SizeIs(1));
  EXPECT_EQ(walks[0].episode, 1U);
  EXPECT_THAT(tests::refusal<InvalidInput>([] { parsed("{}", Coverage::kPart); }),
              HasSubstr("no walk for 2 of the 2 episodes"));
}

TEST(ContinuousResults, ReportFaultsWithTheirPaths) {
  EXPECT_THAT(faults("[]"), HasSubstr("$: array, not an object"));
  EXPECT_THAT(faults(""), HasSubstr("the file is empty"));
  EXPECT_THAT(faults(edited(kR2r, "\"9\"", "\"8\"")),
              HasSubstr("$.8: \"8\" is not one of the 2 values of episode_id in split made"));
  EXPECT_THAT(faults(edited(kR2r, "\"9\"", "\"7\"")),
              HasSubstr("$.7: episode_id \"7\" stands at $.7 already"));
  EXPECT_THAT(faults(edited(kR2r, "\"heading\": 0.25, ", "")),
              HasSubstr("$.7[1]: has no field \"heading\""));
  EXPECT_THAT(faults(edited(kR2r, "\"stop\": true", "\"stop\": 1")),
              HasSubstr("$.7[4].stop: number 1, not true or false"));
  EXPECT_THAT(faults(edited(kR2r, "0.25, \"stop\": false", "0.25, \"stop\": true")),
              HasSubstr("$.7[2]: a pose after stop was called"));
  EXPECT_THAT(faults(edited(kR2r, "[1, 0.5, 1.75]", "[1, 0.5]")),
              HasSubstr("$.7[2].position: 2 numbers, not 3"));
  EXPECT_THAT(faults(edited(kR2r, "[1, 0.5, 1.75]", "[1, 1e300, 1.75]")),
              HasSubstr("$.7[2].position: 1e+300 is no place in metres"));
  EXPECT_THAT(faults(edited(kR2r, "[1, 0, 2]", "[1, 0.5, 2]")),
              HasSubstr("$.9[0]: [1, 0.5, 2] is 0.500 m off the episode's start, [1, 0, 2]"));
  EXPECT_THAT(
      faults(edited(kR2r, R"([{"position": [1, 0, 2], "heading": 0, "stop": false}], )", "[], ")),
      HasSubstr("$.9: no pose"));
  EXPECT_THAT(faults(edited(kR2r, "\"stop\": false", "\"stop\": true")),
              HasSubstr("$.9[0]: stop before the first action"));
  EXPECT_THAT(faults(edited(kRxr, "\"91\"", "\"90\"")),
              HasSubstr("$[1].instruction_id: \"90\" is not one of the 2 values"));
  EXPECT_THAT(faults(edited(kRxr, "\"91\"", "93")),
              HasSubstr("$[1].instruction_id: instruction_id \"93\" stands at $[0]"));
  EXPECT_THAT(faults(edited(kRxr, "[[1, 0, 2]]", "[]")), HasSubstr("$[1].path: no pose"));
  EXPECT_THAT(faults(edited(kRxr, "[[1, 0, 2]]", "3")),
              HasSubstr("$[1].path: number 3, not an array"));
}

TEST(ContinuousResults, AreNotWrittenWhereTheirFormCannotSayThem) {
  const auto refusal = [](const auto& damage, ContinuousForm form) {
    auto walks = parsed(kR2r);
    ContinuousEpisodes episodes = two_episodes();
    damage(walks[0], episodes);
    return tests::refusal<ArgumentError>([&] { to_json(walks, episodes, form); });
  };
  constexpr auto kR2rForm = ContinuousForm::kR2r, kRxrForm = ContinuousForm::kRxr;
  EXPECT_THAT(refusal([](auto& walk, auto&) { walk.episode = 2; }, kR2rForm),
              HasSubstr("a walk of episode 2; there are 2"));
  EXPECT_THAT(refusal([](auto& walk, auto&) { walk.actions.pop_back(); }, kR2rForm),
              HasSubstr("the walk of episode 7: 5 positions, 5 headings, 3 actions"));
  EXPECT_THAT(refusal([](auto& walk, auto&) { walk.actions[1] = 0; }, kR2rForm),
              HasSubstr("the walk of episode 7: action 1 is stop, and 2 come after it"));
  EXPECT_THAT(refusal([](auto& walk, auto&) { walk.headings.clear(); }, kR2rForm),
              HasSubstr("its headings are not known"));
  EXPECT_THAT(refusal([](auto& walk,
                         auto&) { walk.positions[1].x = std::numeric_limits<float>::infinity(); },
                      kRxrForm),
              HasSubstr("inf, not a finite number"));
  EXPECT_THAT(refusal([](auto&, auto& all) { all.episodes[0].instruction.id.reset(); }, kRxrForm),
              HasSubstr("the walk of episode 7: it has no instruction id"));
}

TEST(ContinuousResults, AreScored) {
  const auto walks = parsed(kR2r);
  const ScoredWalk scored = to_score(walks[0], {4, 4, 2, 2, 2});
  const std::vector<Point3> reference = reference_to_score(std::vector{Vec3d{1, -2, 0}});
  EXPECT_THAT(reference, ElementsAre(Point3{1, 0, 2}));
  const ContinuousScore score = score_continuous(scored.view(), reference);
  EXPECT_EQ(score.success, 1);
  EXPECT_EQ(score.distance_to_goal, 2);
  EXPECT_EQ(score.steps_taken, 4);
  EXPECT_NEAR(score.path_length, std::hypot(0.25, 0.5), 1e-6);
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { to_score(walks[0], {4}); }),
              HasSubstr("1 distances to the goal of 5 positions"));
}

// Experts' walks as results: actions that are told from poses are those of the expert.
TEST(RealContinuousResults, TellTheExpertsActionsFromItsPoses) {
  const auto data = scan::DataRoot::from_environment();
  if (!data || !std::filesystem::exists(data->folder() / "vlnce")) {
    GTEST_SKIP() << "ENFILADE_DATA is not set, or has no files of VLN-CE: vlnce/*.json.gz";
  }
  for (const std::string split : {"val_seen", "val_unseen"}) {
    const auto folder = data->folder() / "vlnce";
    const auto episodes = load_continuous_episodes(folder / (split + ".json.gz"), split);
    const auto experts = load_expert_walks(folder / (split + "_gt.json.gz"));
    std::vector<ContinuousResult> walks;
    for (std::size_t i = 0; i < episodes.episodes.size(); ++i) {
      const ContinuousEpisode& episode = episodes.episodes[i];
      const ExpertWalk& expert = experts.at(text_of(episode.id));
      ContinuousResult walk{i, {to_float(episode.start)}, {episode.start_heading()}, {}, {}};
      std::size_t at = 0;
      for (const std::uint8_t action : expert.actions) {
        const double turn = action == 2 ? -15 : action == 3 ? 15 : 0;
        at += action == 1 ? 1 : 0;
        walk.positions.push_back(to_float(expert.locations[at]));
        walk.headings.push_back(wrap_heading(walk.headings.back() + degrees(turn)));
        walk.actions.push_back(action);
      }
      walks.push_back(std::move(walk));
    }
    const std::string text = to_json(walks, episodes, ContinuousForm::kR2r);
    const auto read = parse_continuous_results(text, "<text>", episodes);
    EXPECT_TRUE(read == walks) << split;
    double ndtw = 0, success = 0;
    for (const ContinuousResult& walk : read) {
      const ContinuousEpisode& episode = episodes.episodes[walk.episode];
      // As if nothing stood between the expert and the goal.
      std::vector<double> distances;
      for (const Vec3f position : walk.positions) {
        distances.push_back(length(to_double(position) - episode.goals->at(0).position));
      }
      const auto reference = reference_to_score(experts.at(text_of(episode.id)).locations);
      const auto score = score_continuous(to_score(walk, distances).view(), reference);
      ndtw += score.ndtw;
      success += score.success;
    }
    EXPECT_EQ(ndtw, static_cast<double>(read.size()));
    EXPECT_EQ(success, static_cast<double>(read.size()));
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
