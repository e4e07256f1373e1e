#include "enfilade/tasks/derive_continuous.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>

#include "enfilade/scan/data_root.h"
#include "tests/support/graphs.h"
#include "tests/support/refusal.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::shared_ptr<const graph::GraphSet> squares() {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::square("one"));
  graphs.emplace_back(graph::testing::square("two"));
  return graph::GraphSet::of(std::move(graphs));
}

PathAnnotation path(std::int64_t id, const std::string& scan, std::vector<std::string> viewpoints,
                    std::vector<std::string> instructions) {
  return {id, scan, Radians(1.5), std::move(viewpoints), 4.0, std::move(instructions)};
}

Annotations three_paths() {
  Annotations annotations{"made", "R2R_made.json", {}};
  annotations.paths = {path(7, "two", {"v0", "v1", "v2"}, {"Go. ", "Walk. "}),
                       path(9, "one", {"v1", "v2"}, {"Turn. "}),
                       path(8, "two", {"v2", "v1"}, {"Back. "})};
  return annotations;
}

// A floor 1 m under the viewpoints, where nobody stands at `missing` or walks from `shut` on.
class MadeFloor : public EpisodeFloor {
 public:
  std::optional<Vec3d> node_of(const graph::NavGraph& graph, ViewpointIndex v) const override {
    asked.push_back(graph.scan() + "/" + graph.id(v));
    if (graph.id(v) == missing) return std::nullopt;
    return to_double(graph.position(v)) - Vec3d{0, 0, 1};
  }
  WalkedNodes walk(const graph::NavGraph& graph, std::span<const Vec3d> nodes) const override {
    const auto start = graph.find(shut);
    if (start && to_double(graph.position(*start)) - Vec3d{0, 0, 1} == nodes.front()) {
      return {"a wall stands between node 0 and node 1", {}};
    }
    return {"", 2.5};
  }

  std::string missing = "", shut = "";
  mutable std::vector<std::string> asked;
};

std::vector<std::string> ids(const ContinuousEpisodes& episodes) {
  std::vector<std::string> all;
  for (const auto& one : episodes.episodes) {
    all.push_back(text_of(one.id) + " of " + text_of(one.trajectory_id));
  }
  return all;
}

TEST(DeriveContinuous, MakesAnEpisodeOfEachInstructionInTheirOrder) {
  const MadeFloor floor;
  const auto [all, dropped] = derive_continuous(three_paths(), *squares(), floor);
  EXPECT_THAT(dropped, IsEmpty());
  EXPECT_EQ(all.split, "made");
  EXPECT_THAT(ids(all), ElementsAre("1 of 7", "2 of 7", "3 of 9", "4 of 8"));
  const ContinuousEpisode& second = all.episodes[1];
  EXPECT_EQ(second.instruction, ContinuousInstruction{"Walk. "});
  EXPECT_EQ(second.scene, "mp3d/two/two.glb");
  EXPECT_EQ(second.scan(), "two");
  EXPECT_NEAR(second.start_heading().value, 1.5, 1e-12);
  EXPECT_EQ(second.info->geodesic_distance, 2.5);
  EXPECT_FALSE(second.info->role);
  const graph::NavGraph graph(graph::testing::square("two"));
  const auto node = [&graph](const char* id) {
    return to_double(graph.position(*graph.find(id))) - Vec3d{0, 0, 1};
  };
  EXPECT_THAT(*second.reference_path, ElementsAre(node("v0"), node("v1"), node("v2")));
  EXPECT_EQ(second.start, node("v0"));
  EXPECT_THAT(*second.goals, ElementsAre(ContinuousGoal{node("v2"), 3.0}));
  EXPECT_EQ(parse_continuous_episodes(to_json(all), "<text>", "made").episodes, all.episodes);
}

TEST(DeriveContinuous, AsksOnceAViewpointAndForOneScanAfterTheOther) {
  const MadeFloor floor;
  derive_continuous(three_paths(), *squares(), floor);
  EXPECT_THAT(floor.asked, ElementsAre("one/v1", "one/v2", "two/v0", "two/v1", "two/v2"));
}

TEST(DeriveContinuous, DropsWhatCannotBeWalkedAndSaysWhy) {
  MadeFloor floor;
  floor.missing = "v0";
  floor.shut = "v1";
  Annotations annotations = three_paths();
  annotations.paths.push_back(path(10, "one", {"v2", "v1"}, {}));
  const auto [all, dropped] = derive_continuous(annotations, *squares(), floor);
  EXPECT_THAT(ids(all), ElementsAre("1 of 8"));
  EXPECT_THAT(dropped,
              ElementsAre(DroppedPath{0, "7", "two", "a body cannot stand at viewpoint v0"},
                          DroppedPath{1, "9", "one", "a wall stands between node 0 and node 1"},
                          DroppedPath{3, "10", "one", "it has no instruction"}));
}

TEST(DeriveContinuous, GivesATrajectoryOneRandomHeadingFromTheSeed) {
  const GuessedFloor floor;
  DeriveOptions options;
  options.start_headings = StartHeadings::kRandom;
  const auto headings = [&] {
    std::vector<double> all;
    const auto derived = derive_continuous(three_paths(), *squares(), floor, options);
    for (const auto& one : derived.episodes.episodes) all.push_back(one.start_heading().value);
    return all;
  };
  const std::vector<double> first = headings();
  EXPECT_EQ(first[0], first[1]);
  EXPECT_NE(first[0], first[2]);
  EXPECT_EQ(headings(), first);
  options.seed = 2;
  EXPECT_NE(headings(), first);
}

TEST(DeriveContinuous, TakesOptions) {
  const GuessedFloor floor;
  DeriveOptions options;
  options.radius = 1.5;
  options.scene_folder = "homes";
  options.first_id = 100;
  const auto all = derive_continuous(three_paths(), *squares(), floor, options).episodes;
  EXPECT_EQ(all.episodes[0].id, FileId(100));
  EXPECT_EQ(all.episodes[0].scene, "homes/two/two.glb");
  EXPECT_EQ(all.episodes[0].goals->at(0).radius, 1.5);
  EXPECT_FALSE(all.episodes[0].info->geodesic_distance);
  EXPECT_THAT(all.vocabulary->words, IsEmpty());
  options.vocabulary.emplace();
  options.vocabulary->words = {"<pad>", "<unk>", "go"};
  const auto told = derive_continuous(three_paths(), *squares(), floor, options).episodes;
  EXPECT_EQ(told.episodes[0].instruction.tokens->size(), 200U);
  EXPECT_EQ(told.episodes[0].instruction.tokens->at(0), 2);
  EXPECT_EQ(told.vocabulary, options.vocabulary);
  options.radius = -1;
  EXPECT_THAT(tests::refusal<ArgumentError>(
                  [&] { derive_continuous(three_paths(), *squares(), floor, options); }),
              HasSubstr("radius: -1"));
}

TEST(DeriveContinuous, NamesTheScenesOfHm3d) {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::square("00800-TEEsavR23oF"));
  Annotations annotations = three_paths();
  annotations.paths = {path(7, "00800-TEEsavR23oF", {"v0", "v1"}, {"Go."})};
  const GuessedFloor floor;
  const auto all =
      derive_continuous(annotations, *graph::GraphSet::of(std::move(graphs)), floor).episodes;
  EXPECT_EQ(all.episodes.at(0).scene, "hm3d/val/00800-TEEsavR23oF/TEEsavR23oF.basis.glb");
  EXPECT_EQ(all.episodes.at(0).scan(), "00800-TEEsavR23oF");
}

TEST(DeriveContinuous, HidesHiddenGoals) {
  Annotations annotations = three_paths();
  annotations.paths = {path(7, "two", {"v0"}, {"Go."})};
  const GuessedFloor floor;
  const auto all = derive_continuous(annotations, *squares(), floor).episodes;
  ASSERT_EQ(all.episodes.size(), 1U);
  EXPECT_TRUE(all.episodes[0].goal_hidden());
  EXPECT_FALSE(all.episodes[0].reference_path || all.episodes[0].info);
}

TEST(DeriveContinuous, MakesRxrsFormOfRxr) {
  Annotations annotations = three_paths();
  annotations.task = Task::kRxr;
  annotations.paths = {path(7, "two", {"v0", "v1"}, {"Go."})};
  InstructionDetails details;
  details.id = "7_26";
  details.language = "en-IN";
  details.words = {TimedWord{"Go.", 0.5, 1.0}};
  annotations.paths[0].details = {details};
  const GuessedFloor floor;
  const auto all = derive_continuous(annotations, *squares(), floor).episodes;
  const ContinuousEpisode& one = all.episodes.at(0);
  EXPECT_EQ(one.id, FileId("1"));
  EXPECT_EQ(one.trajectory_id, FileId("7"));
  EXPECT_EQ(one.info->role, AnnotationRole::kGuide);
  EXPECT_EQ(one.instruction.id, FileId("26"));
  EXPECT_EQ(one.instruction.language, "en-IN");
  EXPECT_EQ(*one.instruction.words, details.words);
}

TEST(DeriveContinuous, RefusesOtherBenchmarks) {
  Annotations annotations = three_paths();
  annotations.task = Task::kReverie;
  const GuessedFloor floor;
  EXPECT_THAT(
      tests::refusal<ArgumentError>([&] { derive_continuous(annotations, *squares(), floor); }),
      HasSubstr("annotations of REVERIE: continuous episodes are made of R2R"));
}

// VLN-CE's files against what is derived from R2R alone.
TEST(RealDerivedEpisodes, AreNearVlnCesWithoutAMesh) {
  const auto data = scan::DataRoot::from_environment();
  if (!data || !std::filesystem::exists(data->folder() / "vlnce")) {
    GTEST_SKIP() << "ENFILADE_DATA is not set, or has no files of VLN-CE: vlnce/*.json.gz";
  }
  const auto graphs = graph::GraphSet::open(data->connectivity());
  const GuessedFloor floor;
  std::map<std::vector<double>, Vec3d> nodes;  // theirs, ours
  for (const char* split : {"train", "val_seen", "val_unseen", "test"}) {
    const auto derived =
        derive_continuous(load_annotations(data->annotations(split), split), *graphs, floor);
    EXPECT_THAT(derived.dropped, IsEmpty());
    std::unordered_map<std::string, std::vector<const ContinuousEpisode*>> ours;
    for (const auto& one : derived.episodes.episodes) {
      ours[text_of(one.trajectory_id)].push_back(&one);
    }
    std::unordered_map<std::string, std::size_t> seen;
    const auto file = data->folder() / "vlnce" / (std::string(split) + ".json.gz");
    for (const auto& theirs : load_continuous_episodes(file, split).episodes) {
      const std::string id = text_of(theirs.trajectory_id);
      const ContinuousEpisode& made = *ours.at(id).at(seen[id]++);
      EXPECT_EQ(made.instruction.text, theirs.instruction.text);
      EXPECT_EQ(made.scene, theirs.scene);
      EXPECT_EQ(made.goal_hidden(), theirs.goal_hidden());
      const std::vector<Vec3d> known = theirs.reference_path.value_or(std::vector{theirs.start});
      const std::vector<Vec3d> derived_nodes =
          made.reference_path.value_or(std::vector{made.start});
      ASSERT_EQ(known.size(), derived_nodes.size());
      for (std::size_t k = 0; k < known.size(); ++k) {
        nodes.emplace(std::vector{known[k].x, known[k].y, known[k].z}, derived_nodes[k]);
      }
    }
  }
  std::vector<double> horizontal, vertical;
  for (const auto& [theirs, ours] : nodes) {
    horizontal.push_back(std::hypot(theirs[0] - ours.x, theirs[1] - ours.y));
    vertical.push_back(std::abs(theirs[2] - ours.z));
  }
  const auto share = [](const std::vector<double>& values, double most) {
    return static_cast<double>(
               std::ranges::count_if(values, [most](double value) { return value <= most; })) /
           static_cast<double>(values.size());
  };
  EXPECT_EQ(nodes.size(), 6643U);  // viewpoints
  EXPECT_NEAR(share(horizontal, 1e-3), 0.975, 5e-4);
  EXPECT_NEAR(share(vertical, 0.05), 0.596, 5e-4);
  EXPECT_NEAR(share(vertical, 0.1), 0.951, 5e-4);
  EXPECT_NEAR(share(vertical, 0.2), 0.985, 5e-4);
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
