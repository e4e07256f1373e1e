// A set of homes with all benchmarks, read back as anybody reads them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/scan/connectivity.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/metrics.h"
#include "enfilade/tasks/objects.h"
#include "tests/support/folder_content.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::homes::benchmarks {
namespace EN_UNIT {

namespace fs = std::filesystem;
using tasks::Annotations;
using tasks::PathAnnotation;
using tasks::Task;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

HomeSetOptions three_homes() {
  HomeSetOptions options = home_set_preset("graphs");
  options.homes = 3;
  return options;
}

// Made once; the tests only read it.
const fs::path& folder() {
  static const tests::TemporaryFolder kFolder("benchmarks");
  static const bool kMade = [] {
    write_homes(kFolder.path(), three_homes());
    write_home_paths(kFolder.path(), {.per_home = 30});
    return true;
  }();
  EXPECT_TRUE(kMade);
  return kFolder.path();
}

Annotations read(Task task, const std::string& split, const fs::path& root = folder()) {
  for (const fs::path& place : tasks::episode_places(tasks::benchmark(task), split)) {
    if (fs::exists(root / place)) return tasks::load_annotations(root / place, split, task);
  }
  ADD_FAILURE() << tasks::benchmark(task).name << " has no " << split;
  return {};
}

// Its own splits of a task, the last one hidden.
std::vector<std::string> splits_of(Task task) {
  if (task == Task::kR4r) return {"train", "val_seen", "val_unseen"};
  if (task == Task::kCvdn) return {"train", "val_seen", "val_unseen", "test_cleaned"};
  if (task == Task::kSoon) {
    return {"train", "val_seen_instrs", "val_unseen_instrs", "val_unseen_house", "test"};
  }
  return {"train", "val_seen", "val_unseen", "test"};
}

constexpr std::array kAll{Task::kR2r, Task::kR2rLast, Task::kR2rBack, Task::kR4r,
                          Task::kRxr, Task::kReverie, Task::kCvdn,    Task::kSoon};

tasks::ObjectBoxes boxes() {
  for (const fs::path& place : tasks::object_places()) {
    if (fs::exists(folder() / place)) return tasks::ObjectBoxes::load(folder() / place);
  }
  ADD_FAILURE() << "no boxes";
  return {};
}

TEST(HomeBenchmarks, AreFoundAndFitTheGraphs) {
  const auto graphs = graph::GraphSet::open(folder() / "connectivity");
  const tasks::ObjectBoxes objects = boxes();
  for (const Task task : kAll) {
    for (const std::string& split : splits_of(task)) {
      const Annotations annotations = read(task, split);
      // Of so few paths, none may be near enough to be joined.
      const bool few = task == Task::kR4r && split == "val_seen";
      EXPECT_TRUE(few || !annotations.paths.empty()) << tasks::benchmark(task).name << " " << split;
      const tasks::EpisodeSet episodes =
          tasks::make_episodes(annotations, graphs, tasks::Instructions::kScored, &objects);
      EXPECT_GE(episodes.episodes.size(), annotations.paths.size());
      for (const tasks::ReferencePath& path : episodes.paths) {
        EXPECT_EQ(goal_hidden(path), split.starts_with("test")) << tasks::benchmark(task).name;
        const auto* const object = std::get_if<tasks::SeenObject>(&path.goal);
        if (object == nullptr) continue;
        EXPECT_EQ(std::ranges::count(object->seen_from, path.viewpoints.back()), 1)
            << "the end of the path sees the object";
      }
    }
  }
}

TEST(HomeBenchmarks, SayThatTheyAreSynthetic) {
  for (const std::string& task : home_tasks()) {
    EXPECT_THAT(read_file(folder() / task / "README.md"), HasSubstr("SYNTHETIC")) << task;
  }
}

// Of the instructions. Public lines of RxR have no path_id, so that ids are their last part alone.
std::vector<std::string> ids_of(const Annotations& annotations) {
  std::vector<std::string> ids;
  for (const PathAnnotation& path : annotations.paths) {
    for (std::size_t k = 0; k < path.instructions.size(); ++k) {
      const std::string id = tasks::instruction_id(path, k);
      ids.push_back(annotations.task == Task::kRxr ? id.substr(id.rfind('_') + 1) : id);
    }
  }
  return ids;
}

TEST(HomeBenchmarks, HiddenFilesHoldTheGoalsOfTestSplits) {
  for (const Task task : kAll) {
    if (task == Task::kR4r) continue;
    const fs::path root = task == Task::kR2r ? folder() : folder() / "hidden";
    const std::string split = splits_of(task).back();
    const Annotations open = read(task, split);
    Annotations whole;
    if (task == Task::kR2r) {
      whole = tasks::load_annotations(folder() / "hidden/R2R_test.json", "test", task);
    } else {
      whole = read(task, split, root);
    }
    ASSERT_EQ(open.paths.size(), whole.paths.size()) << tasks::benchmark(task).name;
    EXPECT_EQ(ids_of(open), ids_of(whole)) << tasks::benchmark(task).name;
    for (std::size_t i = 0; i < open.paths.size(); ++i) {
      EXPECT_FALSE(whole.paths[i].goal_hidden());
      EXPECT_EQ(open.paths[i].path.size(), 1U);
      EXPECT_EQ(open.paths[i].path[0], whole.paths[i].path[0]);
      EXPECT_EQ(open.paths[i].instructions, whole.paths[i].instructions);
    }
  }
}

TEST(HomeBenchmarks, R2rLastAndBackComeFromR2r) {
  const Annotations r2r = read(Task::kR2r, "train"), last = read(Task::kR2rLast, "train"),
                    back = read(Task::kR2rBack, "train");
  ASSERT_EQ(last.paths.size(), r2r.paths.size());
  ASSERT_EQ(back.paths.size(), r2r.paths.size());
  for (std::size_t i = 0; i < r2r.paths.size(); ++i) {
    const PathAnnotation& path = r2r.paths[i];
    EXPECT_EQ(last.paths[i].path, path.path);
    std::vector<std::string> there = back.paths[i].path;
    ASSERT_EQ(there.size(), 2 * path.path.size() - 1);
    EXPECT_TRUE(std::ranges::equal(there, std::vector(there.rbegin(), there.rend())));
    there.resize(path.path.size());
    EXPECT_EQ(there, path.path);
    EXPECT_EQ(back.paths[i].goal, tasks::NamedGoal(tasks::NamedTurningPoint{path.path.back()}));
    for (std::size_t k = 0; k < path.instructions.size(); ++k) {
      const std::string& sentence = last.paths[i].instructions[k];
      EXPECT_TRUE(path.instructions[k].ends_with(sentence));
      EXPECT_EQ(sentence.find(". "), std::string::npos);
      EXPECT_TRUE(back.paths[i].instructions[k].starts_with(path.instructions[k]));
    }
  }
}

TEST(HomeBenchmarks, R4rJoinsPathsThatAreNear) {
  const auto graphs = graph::GraphSet::open(folder() / "connectivity");
  const Annotations r2r = read(Task::kR2r, "train"), r4r = read(Task::kR4r, "train");
  std::map<std::string, std::vector<const PathAnnotation*>> by_start;
  for (const PathAnnotation& path : r2r.paths) by_start[path.path.front()].push_back(&path);
  for (const PathAnnotation& joined : r4r.paths) {
    EXPECT_EQ(joined.instructions.size(), 9U);
    const graph::NavGraph& graph = graphs->graph(joined.scan);
    const bool fits = std::ranges::any_of(by_start[joined.path.front()], [&](const auto* first) {
      if (!std::ranges::equal(first->path, std::span(joined.path).first(first->path.size()))) {
        return false;
      }
      return std::ranges::any_of(r2r.paths, [&](const PathAnnotation& second) {
        return second.path.back() == joined.path.back() &&
               graph.distance(graph.find(first->path.back()).value(),
                              graph.find(second.path.front()).value()) <= 3;
      });
    });
    EXPECT_TRUE(fits) << joined.path_id;
  }
}

TEST(HomeBenchmarks, FineGrainedPiecesCoverPathAndWords) {
  for (const std::string split : {"train", "val_seen", "val_unseen", "test"}) {
    const Annotations pieces = tasks::load_annotations(
        folder() / "fgr2r" / ("FGR2R_" + split + ".json"), split, Task::kR2r);
    ASSERT_FALSE(pieces.paths.empty());
    for (const PathAnnotation& path : pieces.paths) {
      ASSERT_EQ(path.details.size(), path.instructions.size());
      for (const tasks::InstructionDetails& details : path.details) {
        ASSERT_FALSE(details.parts.empty());
        EXPECT_EQ(details.parts.front().places.has_value(), split != "test");
        if (split != "test") {
          EXPECT_EQ(details.parts.back().places->second, path.path.size() - 1);
        }
      }
    }
  }
}

TEST(HomeBenchmarks, FollowersHaveTheMetricsOfTheirWalks) {
  const auto graphs = graph::GraphSet::open(folder() / "connectivity");
  const Annotations guides = read(Task::kRxr, "val_unseen");
  const auto walks = tasks::load_demonstrations(folder() / "rxr/rxr_val_unseen_follower.jsonl");
  ASSERT_EQ(walks.size(), guides.paths.size());
  std::set<std::string> languages;
  for (std::size_t i = 0; i < walks.size(); ++i) {
    const PathAnnotation& guide = guides.paths[i];
    languages.insert(guide.details.at(0).language);
    EXPECT_TRUE(guide.details[0].id.ends_with("_" + std::to_string(walks[i].instruction_id)));
    const graph::NavGraph& graph = graphs->graph(guide.scan);
    const auto look_up = [&](const std::vector<std::string>& ids) {
      std::vector<ViewpointIndex> path;
      for (const std::string& id : ids) path.push_back(graph.find(id).value());
      return path;
    };
    const auto metrics = tasks::compute_metrics(graph, look_up(walks[i].path), look_up(guide.path));
    EXPECT_NEAR(metrics.ndtw, walks[i].ndtw, 1e-9);
    EXPECT_NEAR(metrics.spl, walks[i].spl, 1e-9);
  }
  EXPECT_EQ(languages.size(), 2U);
}

TEST(HomeBenchmarks, SoonHasBothForms) {
  for (const std::string& split : splits_of(Task::kSoon)) {
    Annotations released = read(Task::kSoon, split);
    const Annotations lines =
        tasks::load_annotations(folder() / "soon" / (split + ".jsonl"), split, Task::kSoon);
    for (PathAnnotation& path : released.paths) {
      path.group.reset();
      for (auto& details : path.details) details.entry.reset();
      if (auto* const goal = std::get_if<tasks::NamedBoxes>(&path.goal)) {
        goal->first_alternative.clear();
      }
    }
    EXPECT_TRUE(lines.paths == released.paths) << split;
  }
}

TEST(HomeBenchmarks, AreTheSameAgainAndOnlyThoseThatAreAskedFor) {
  const tests::TemporaryFolder again("benchmarks_again"), few("benchmarks_few");
  write_homes(again.path(), three_homes());
  write_home_paths(again.path(), {.per_home = 30, .threads = 1});
  EXPECT_TRUE(tests::content_of(folder()) == tests::content_of(again.path()));
  write_homes(few.path(), three_homes());
  write_home_paths(few.path(), {.per_home = 30, .tasks = {"r2r", "cvdn"}});
  for (const std::string& task : home_tasks()) {
    EXPECT_EQ(fs::exists(few.path() / task), task == "cvdn") << task;
  }
  EXPECT_EQ(read_file(few.path() / "cvdn/train.json"), read_file(folder() / "cvdn/train.json"))
      << "what is written of one task does not depend on others";
  EXPECT_THAT(
      tests::refusal<ArgumentError>([&] { write_home_paths(few.path(), {.tasks = {"r3r"}}); }),
      HasSubstr("tasks: \"r3r\" is none of r2r-last, r2r-back"));
}

// Another seed or fewer tasks leave no old annotations, and what people put beside them stays.
TEST(HomeBenchmarks, OldAnnotationsGo) {
  const tests::TemporaryFolder made("benchmarks_old"), fresh("benchmarks_fresh");
  const HomePathOptions again{.per_home = 20, .seed = 2, .tasks = {"rxr"}};
  for (const fs::path& place : {made.path(), fresh.path()}) write_homes(place, three_homes());
  write_home_paths(made.path(), {.per_home = 30});
  write_home_paths(made.path(), again);
  write_home_paths(fresh.path(), again);
  EXPECT_TRUE(tests::content_of(made.path()) == tests::content_of(fresh.path()));
  EXPECT_FALSE(fs::exists(made.path() / "reverie")) << "empty folders go too";
  write_file_atomically(made.path() / "rxr/notes.txt", "mine");
  write_home_paths(made.path(), {.per_home = 20, .tasks = {}});
  EXPECT_EQ(read_file(made.path() / "rxr/notes.txt"), "mine");
  EXPECT_FALSE(fs::exists(made.path() / "rxr/README.md"));
  write_file_atomically(made.path() / "annotations.txt", "r2r/R2R_train.json\n../notes.txt\n");
  EXPECT_THAT(tests::refusal<InvalidInput>([&] { write_home_paths(made.path(), again); }),
              HasSubstr("annotations.txt: line 2: \"../notes.txt\", not a path of a file below"));
}

TEST(HomeBenchmarks, AGraphOfAnotherNameIsThereForOldCode) {
  const auto graphs = graph::GraphSet::open(folder() / "connectivity");
  EXPECT_EQ(graphs->find("ZMojNkEp431"), std::nullopt) << "no home of the set";
  EXPECT_THAT(graphs->scans(), ::testing::ElementsAre("home0001", "home0002", "home0003"));
  const graph::NavGraph alias(scan::load_connectivity(folder() / "connectivity", "ZMojNkEp431"));
  const auto viewpoint = alias.find("2f4d90acd4024c269fb0efe49a8ac540");
  ASSERT_TRUE(viewpoint);
  EXPECT_TRUE(alias.included(*viewpoint));
}

}  // namespace EN_UNIT
}  // namespace enfilade::homes::benchmarks
