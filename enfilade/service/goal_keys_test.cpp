// Keys of goals, and what a site hides because of them.
#include "enfilade/service/goal_keys.h"

#include <gmock/gmock.h>
#include <algorithm>
#include <filesystem>
#include <string>

#include "enfilade/core/errors.h"
#include "enfilade/service/site.h"
#include "enfilade/tasks/files.h"
#include "tests/support/graphs.h"
#include "tests/support/refusal.h"
#include "tests/support/secret_phase.h"
#include "tests/support/served_benchmarks.h"

namespace enfilade::service {
namespace EN_UNIT {

using tasks::Task;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using namespace testing;  // NOLINT(google-build-using-namespace)
namespace fs = std::filesystem;

/// A path on the grid of 3 x 3.
tasks::ReferencePath path_of(const std::vector<std::size_t>& viewpoints, tasks::Goal goal = {}) {
  tasks::ReferencePath path;
  for (const std::size_t v : viewpoints) path.viewpoints.emplace_back(v);
  path.goal = std::move(goal);
  return path;
}

GoalKeys keys(const tasks::ReferencePath& path, Task task = Task::kR2r) {
  return goal_keys(std::span(&path, 1), task, *graph::testing::grid());
}

TEST(GoalKeys, AreThoseOfAStartAndEveryEnd) {
  const GoalKeys way = keys(path_of({0, 1, 2}));
  ASSERT_EQ(way.size(), 1U);
  EXPECT_EQ(way[0], 0x6ebc8ea0dbe9582bU) << "databases have such keys";
  EXPECT_EQ(keys(path_of({0, 3, 4, 5, 2})), way) << "by another way";
  EXPECT_NE(keys(path_of({2, 1, 0})), way);
  EXPECT_EQ(keys(path_of({0, 1, 2, 1, 0}, tasks::TurningPoint{ViewpointIndex(2)})), way);
  const auto to = [](std::size_t v) { return ViewpointIndex(v); };
  EXPECT_THAT(keys(path_of({0, 1}, tasks::SeenObject{7, {to(2), to(5)}})), Contains(way[0]));
  EXPECT_THAT(keys(path_of({0, 1}, tasks::Region{{to(5), to(2)}, {}, {}})), Contains(way[0]));
  tasks::Boxes boxes;
  boxes.boxes.push_back({to(2), {}, {}});
  EXPECT_THAT(keys(path_of({0, 1}, boxes)), Contains(way[0]));
  EXPECT_THAT(keys(path_of({0})), IsEmpty());
  EXPECT_THAT(keys(path_of({0}, tasks::HiddenGoal())), IsEmpty());
}

TEST(GoalKeys, AJoinedPathHasThoseOfItsParts) {
  const GoalKeys joined = keys(path_of({0, 1, 2, 5, 8}), Task::kR4r);
  EXPECT_EQ(joined.size(), 10U);
  EXPECT_THAT(joined, Contains(keys(path_of({0, 1, 2}))[0]));
  EXPECT_THAT(joined, Contains(keys(path_of({2, 5, 8}))[0]));
}

TEST(GoalKeys, OfContinuousEpisodesAreThoseOfTheNearestViewpoints) {
  tasks::ContinuousEpisodes episodes;
  tasks::ContinuousEpisode& one = episodes.episodes.emplace_back();
  one.scene = "mp3d/grid/grid.glb";
  one.start = {0.5, 0.5, 0};
  one.goals = {{{7.5, 0.2, 0}, 3}};
  EXPECT_EQ(goal_keys(episodes, *graph::testing::grid()), keys(path_of({0, 1, 2})));
  one.goals.reset();
  one.reference_path = {{{0, 0, 0}, {8, 0, 0}}};
  EXPECT_EQ(goal_keys(episodes, *graph::testing::grid()), keys(path_of({0, 1, 2})));
  one.scene = "mp3d/other/other.glb";
  EXPECT_THAT(goal_keys(episodes, *graph::testing::grid()), IsEmpty());
}

TEST(GoalKeys, TellFromATenthOfTheSmallerSet) {
  GoalKeys one, other;
  for (std::uint64_t k = 0; k < 20; ++k) one.push_back(k);
  for (std::uint64_t k = 19; k < 1000; ++k) other.push_back(k);
  EXPECT_EQ(shared_keys(one, other).shared, 1U);
  EXPECT_EQ(shared_keys(one, other).smaller, 20U);
  EXPECT_FALSE(shared_keys(one, other).tells());
  other.insert(other.begin(), 18);
  EXPECT_TRUE(shared_keys(one, other).tells());
  EXPECT_FALSE(shared_keys({}, {}).tells());
}

/// The hall of 60 secret paths, opened as a site.
class SharedSecrets : public ::testing::Test {
 protected:
  fs::path data() { return target_.served().root() / "data"; }
  void write(const std::string& name, const std::string& text) {
    make_folder((data() / name).parent_path());
    write_file_atomically(data() / name, text);
  }
  std::shared_ptr<const Site> open(const std::string& more = "") {
    target_.served().stop();
    target_.serve("test", more);
    return Site::open(data(), load_phases(target_.served().root() / "phases.json"));
  }
  std::string episodes(const std::string& split, const std::string& task) {
    return target_.served()
        .get("/api/v1/splits/" + split + "/episodes?limit=500&task=" + task)
        ->body;
  }
  /// The first `secret` of the paths, and the others one viewpoint shorter.
  std::string train_of(std::size_t secret) {
    tasks::Annotations train = annotations_of(goals_, true);
    for (std::size_t k = secret; k < kPaths; ++k) train.paths[k].path.pop_back();
    return to_json(train);
  }

  Goals goals_ = draw_goals(1);
  Target target_{goals_, ""};
};

TEST_F(SharedSecrets, AreHiddenInOtherBenchmarks) {
  std::string soon;
  for (const tasks::PathAnnotation& one : annotations_of(goals_, true).paths) {
    const json box = soon_box("hall", one.path.back());
    soon += json{{"path_id", "4-" + std::to_string(one.path_id)},
                 {"scan", "hall"},
                 {"path", one.path},
                 {"instructions", json::array({json{{"full", "Walk to the vase."}}})},
                 {"bboxes", json::array({box})}}
                .dump() +
            "\n";
  }
  write("rxr/rxr_test_guide.jsonl", guides_of(goals_, true));
  write(tasks::episode_places(tasks::benchmark(Task::kSoon), "val_seen").front().string(), soon);
  const auto site = open();
  for (const auto& [split, task] : {std::pair("test", "rxr"), std::pair("val_seen", "soon")}) {
    const std::string body = episodes(split, task);
    EXPECT_THAT(body, AllOf(HasSubstr("\"start\""), HasSubstr("\"goals_hidden\":true"),
                            Not(HasSubstr("\"path\"")), Not(HasSubstr("\"goal\""))));
    EXPECT_THAT(
        site->notices(),
        Contains(AllOf(HasSubstr(std::string(task) + " " + split + " is shown without goals"),
                       HasSubstr("60 of 60 goals are secret in phase test"))));
  }
}

TEST_F(SharedSecrets, OfWhichAFewAreEqualByChanceHideNothing) {
  write("r2r/R2R_train.json", train_of(5));
  EXPECT_THAT(open()->notices(), Contains(HasSubstr("r2r train is shown whole: 5 of 60")));
  const json shown = json::parse(episodes("train", "r2r"));
  for (const json& one : shown.at("episodes")) EXPECT_TRUE(one.contains("path"));
  write("r2r/R2R_train.json", train_of(6));
  EXPECT_THAT(open()->notices(), Contains(HasSubstr("r2r train is shown without goals: 6 of 60")));
  EXPECT_THAT(episodes("train", "r2r"), Not(HasSubstr("\"path\"")));
}

TEST_F(SharedSecrets, LeaveOutJoinedPathsAndDialoguesOnTheWay) {
  // R4R's paths begin with two secret ones.
  tasks::Annotations joined = annotations_of(goals_, true);
  joined.task = Task::kR4r;
  for (tasks::PathAnnotation& one : joined.paths) {
    const std::size_t last = std::stoul(one.path.back().substr(1));
    if (last + 1 < kLength) one.path.push_back(viewpoint(last + 1));
  }
  write("r4r/R4R_val_seen.json", tasks::to_text(joined));
  auto dialogues = json::array();
  for (std::size_t k = 0; k < 10; ++k) {
    dialogues.push_back({{"inst_idx", k + 1},
                         {"scan", "hall"},
                         {"target", "vase"},
                         {"start_pano", {{"heading", 1.5}, {"pano", viewpoint(k)}}},
                         {"dialog_history", json::array()}});
  }
  write("cvdn/test.json", dialogues.dump());
  const auto site = open();
  EXPECT_EQ(site->find_split("val_seen", Task::kR4r), nullptr);
  EXPECT_EQ(site->find_split("test", Task::kCvdn), nullptr);
  EXPECT_THAT(site->notices(), Contains(HasSubstr("r4r val_seen is left out")));
  EXPECT_THAT(site->notices(), Contains(HasSubstr("cvdn test is left out: 10 of 10 dialogues")));
  // A dialogue that has gone on starts where the navigator stands by then.
  for (json& one : dialogues) {
    const json turn{{"nav_idx", 2}, {"role", "navigator"}, {"message", "Here?"}};
    one["dialog_history"] = json::array({turn});
  }
  write("cvdn/test.json", dialogues.dump());
  EXPECT_NE(open()->find_split("test", Task::kCvdn), nullptr);
}

TEST_F(SharedSecrets, AreNoOpenGoalsOfAnotherPhase) {
  write("rxr/rxr_val_seen_guide.jsonl", guides_of(goals_, true));
  EXPECT_THAT(tests::refusal<InvalidInput>(
                  [&] { open(R"(}, {"name": "open", "task": "rxr", "split": "val_seen")"); }),
              AllOf(HasSubstr("phase open has open goals, and 60 of 60 are secret in phase test"),
                    HasSubstr("[open-and-secret]")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
