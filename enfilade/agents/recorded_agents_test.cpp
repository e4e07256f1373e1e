// Panoramas, maps and experts along recorded walks of published agents (DUET, EnvDrop), which lie
// beside the data that ENFILADE_DATA names: each choice is taken from the recording, so that no
// network is needed.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/agents/experts.h"
#include "enfilade/agents/panorama.h"
#include "enfilade/agents/topological_map.h"
#include "enfilade/core/gzip.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/scan/data_root.h"

namespace enfilade::agents {
namespace EN_UNIT {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// Sines and cosines of single-precision angles: their libraries and ours differ in the last bits.
constexpr double kAngle = 1e-6;

std::optional<std::vector<Json>> recorded(const char* name) {
  const auto data = scan::DataRoot::from_environment();
  if (!data) return std::nullopt;
  const fs::path file = fs::absolute(data->folder()) / ".." / "reference" / "agents_golden" / name;
  if (!fs::exists(file)) return std::nullopt;
  const std::string text = read_text_file(file);
  std::vector<Json> episodes;
  for (std::size_t at = 0; at < text.size(); at = text.find('\n', at) + 1) {
    episodes.push_back(Json::parse(text.substr(at, text.find('\n', at) - at)));
  }
  episodes.erase(episodes.begin());  // the header
  return episodes;
}

constexpr const char* kNoRecordedAgents =
    "ENFILADE_DATA is not set, or no recorded agents lie beside it";

std::shared_ptr<const graph::GraphSet> graphs() {
  return graph::GraphSet::open(fs::path(scan::DataRoot::from_environment()->folder()) /
                               "connectivity");
}

void expect_near(const Json& recorded, std::span<const float> ours, double tolerance,
                 const std::string& what) {
  ASSERT_EQ(recorded.size(), ours.size()) << what;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    EXPECT_NEAR(recorded[i].get<double>(), ours[i], tolerance) << what << "[" << i << "]";
  }
}

// One recorded episode of DUET, step by step.
class DuetWalk {
 public:
  DuetWalk(const Json& episode, const graph::NavGraph& graph, ScanIndex scan, PanoramaCache& cache)
      : episode_(episode), graph_(graph), scan_(scan), cache_(cache) {}

  void check() {
    for (const Json& id : episode_["gt_path"]) reference_.push_back(viewpoint(id));
    walked_.push_back(reference_.front());
    for (const Json& step : episode_["steps"]) {
      what_ = episode_["instr_id"].get<std::string>() + " step " + step["t"].dump();
      here_ = walked_.back();
      ASSERT_EQ(graph_.id(here_), step["viewpoint"].get<std::string>()) << what_;
      const Panorama& panorama = cache_.at({scan_, here_});
      map_.arrive(graph_, here_, panorama.candidates, step["t"].get<std::uint32_t>());
      heading_ = Radians(step["heading"].get<double>());
      elevation_ = Radians(step["elevation"].get<double>());
      check_candidates(step, panorama);
      check_map(step);
      check_features(step, panorama);
      check_experts(step);
      stops_.remember(map_.find(here_).value(), step["stop_prob"].get<double>());
      if (::testing::Test::HasFatalFailure()) return;
      if (step["go_to"].is_null() || !step.contains("arrives")) break;
      move(step);
    }
    check_end();
  }

 private:
  ViewpointIndex viewpoint(const Json& id) const {
    return graph_.find(id.get<std::string>()).value();
  }

  void check_candidates(const Json& step, const Panorama& panorama) {
    ASSERT_EQ(panorama.candidates.size(), step["candidates"].size()) << what_;
    EXPECT_EQ(panorama.token_views.size(), step["token_count"].get<std::size_t>()) << what_;
    for (std::size_t i = 0; i < panorama.candidates.size(); ++i) {
      const sim::Candidate& ours = panorama.candidates[i];
      const Json& theirs = step["candidates"][i];
      EXPECT_EQ(graph_.id(ours.viewpoint), theirs[0].get<std::string>()) << what_;
      EXPECT_EQ(ours.view, theirs[1].get<std::uint32_t>()) << what_;
      const Radians right(ours.heading.value - heading_.value);
      const Radians up(ours.elevation.value - elevation_.value);
      EXPECT_NEAR(right.value, theirs[2].get<double>(), 1e-9) << what_;
      EXPECT_NEAR(up.value, theirs[3].get<double>(), 1e-9) << what_;
      expect_near(step["candidate_angles"][i], angle_feature(right, up), kAngle, what_);
    }
  }

  void check_map(const Json& step) {
    ASSERT_EQ(map_.size(), step["nodes"].size()) << what_;
    const auto rows = map_.rows();
    std::size_t pair = 0;
    EXPECT_EQ(step["step_ids"][0], 0) << what_;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      EXPECT_EQ(graph_.id(map_.viewpoint(rows[i])), step["nodes"][i].get<std::string>()) << what_;
      EXPECT_EQ(map_.visited(rows[i]), step["visited"][i].get<int>() != 0) << what_;
      EXPECT_EQ(map_.step_id(rows[i]), step["step_ids"][i + 1].get<std::uint32_t>()) << what_;
      for (std::size_t j = i + 1; j < rows.size(); ++j) {
        // Recorded in single precision: metres, at most 100.
        EXPECT_NEAR(map_.distance(rows[i], rows[j]), step["pair_distances"][pair++].get<double>(),
                    1e-5)
            << what_;
      }
    }
    EXPECT_EQ(pair, step["pair_distances"].size()) << what_;
  }

  void check_features(const Json& step, const Panorama& panorama) {
    const auto feature = [&](TopologicalMap::Node node) {
      return map_feature(map_, map_.find(here_).value(), node, heading_, elevation_);
    };
    const auto rows = map_.rows();
    expect_near(step["gmap_pos_fts"][0], kStopFeature, kAngle, what_);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      expect_near(step["gmap_pos_fts"][i + 1], feature(rows[i]), kAngle, what_);
    }
    expect_near(step["start_pos_fts"], feature(0), kAngle, what_);
    for (std::size_t i = 0; i < panorama.candidates.size(); ++i) {
      expect_near(step["cand_pos_fts"][i],
                  feature(map_.find(panorama.candidates[i].viewpoint).value()), kAngle, what_);
    }
  }

  void check_experts(const Json& step) {
    for (const ExpertRule rule : {ExpertRule::kSpl, ExpertRule::kNdtw}) {
      const Json label = step["expert"].value(std::string(to_string(rule)), Json());
      if (label.is_null()) continue;
      const auto ours = map_expert({graph_, map_, walked_, reference_}, rule);
      const auto row = label.get<std::int64_t>();
      if (row < 0) {
        EXPECT_EQ(ours, std::nullopt) << what_;
      } else if (row == 0) {
        EXPECT_EQ(ours, here_) << what_;
      } else {
        EXPECT_EQ(ours, map_.viewpoint(map_.rows()[static_cast<std::size_t>(row) - 1]))
            << what_ << " " << to_string(rule);
      }
    }
  }

  void move(const Json& step) {
    const auto from = map_.find(here_).value();
    std::vector<ViewpointIndex> path;
    map_.path(from, map_.find(viewpoint(step["go_to"])).value(), path);
    ASSERT_EQ(path.size(), step["walked"].size()) << what_;
    for (std::size_t i = 0; i < path.size(); ++i) {
      EXPECT_EQ(graph_.id(path[i]), step["walked"][i].get<std::string>()) << what_;
    }
    const ViewpointIndex last = path.size() > 1 ? path[path.size() - 2] : here_;
    const auto view = arrival_view(cache_.at({scan_, last}), path.back());
    ASSERT_TRUE(view.has_value()) << what_;
    EXPECT_EQ(*view, step["arrives"][1].get<std::uint32_t>()) << what_;
    EXPECT_NEAR(view_heading(*view).value, step["arrives"][2].get<double>(), 1e-12) << what_;
    EXPECT_NEAR(view_elevation(*view).value, step["arrives"][3].get<double>(), 1e-12) << what_;
    walked_.insert(walked_.end(), path.begin(), path.end());
  }

  // The walk back after the last action, also after a stop of its own.
  void check_end() {
    const Json& ends = episode_["steps"].back()["ends"];
    const LastAction last = ends == "stop"    ? LastAction::kStop
                            : ends == "limit" ? LastAction::kLimit
                                              : LastAction::kNothingOpen;
    std::vector<ViewpointIndex> back;
    final_walk(map_, map_.find(here_).value(), stops_, last, FinalStop::kAlways, back);
    EXPECT_EQ(graph_.id(back.empty() ? here_ : back.back()),
              episode_["stop_node"].get<std::string>())
        << what_;
    if (back.empty()) return;
    const Json& entry = episode_["trajectory"].back();
    ASSERT_EQ(back.size(), entry.size()) << what_;
    for (std::size_t i = 0; i < back.size(); ++i)
      EXPECT_EQ(graph_.id(back[i]), entry[i].get<std::string>()) << what_;
  }

  const Json& episode_;
  const graph::NavGraph& graph_;
  ScanIndex scan_;
  PanoramaCache& cache_;
  TopologicalMap map_;
  StopMemory stops_;
  std::vector<ViewpointIndex> reference_, walked_;
  ViewpointIndex here_;
  Radians heading_, elevation_;
  std::string what_;
};

class RecordedDuet : public ::testing::TestWithParam<const char*> {};

TEST_P(RecordedDuet, MapsFeaturesAndExpertsAreTheRecordedOnes) {
  const auto episodes = recorded(GetParam());
  if (!episodes) GTEST_SKIP() << kNoRecordedAgents;
  const auto set = graphs();
  PanoramaCache cache(set);
  std::size_t steps = 0;
  for (const Json& episode : *episodes) {
    const auto scan = episode["scan"].get<std::string>();
    DuetWalk(episode, set->graph(scan), set->at(scan), cache).check();
    if (HasFatalFailure()) return;
    steps += episode["steps"].size();
  }
  EXPECT_GT(steps, 90U);
}
INSTANTIATE_TEST_SUITE_P(All, RecordedDuet,
                         ::testing::Values("duet_r2r_episodes.jsonl.gz",
                                           "duet_reverie_episodes.jsonl.gz"));

TEST(RecordedEnvDrop, CandidatesMovesAndTeacherAreTheRecordedOnes) {
  const auto episodes = recorded("envdrop_episodes.jsonl.gz");
  if (!episodes) GTEST_SKIP() << kNoRecordedAgents;
  const auto set = graphs();
  PanoramaCache cache(set);
  for (const Json& episode : *episodes) {
    const auto scan = episode["scan"].get<std::string>();
    const graph::NavGraph& graph = set->graph(scan);
    const auto goal = graph.find(episode["gt_path"].back().get<std::string>()).value();
    for (const Json& step : episode["steps"]) {
      const std::string what = episode["instr_id"].get<std::string>() + " step " + step["t"].dump();
      const auto here = graph.find(step["viewpoint"].get<std::string>()).value();
      const Panorama& panorama = cache.at({set->at(scan), here});
      const Radians heading(step["heading"].get<double>());
      ASSERT_EQ(panorama.candidates.size(), step["candidates"].size()) << what;
      for (std::size_t i = 0; i < panorama.candidates.size(); ++i) {
        const sim::Candidate& ours = panorama.candidates[i];
        EXPECT_EQ(graph.id(ours.viewpoint), step["candidates"][i][0].get<std::string>()) << what;
        EXPECT_EQ(ours.view, step["candidates"][i][1].get<std::uint32_t>()) << what;
        // Relative heading, absolute elevation.
        expect_near(step["candidate_angles"][i],
                    angle_feature(Radians(ours.heading.value - heading.value), ours.elevation),
                    kAngle, what);
      }
      const auto next = next_on_shortest(graph, here, goal).value();
      const auto teacher = step["teacher"].get<std::size_t>();
      if (next == here) {
        EXPECT_EQ(teacher, panorama.candidates.size()) << what;
      } else {
        EXPECT_EQ(panorama.candidates.at(teacher).viewpoint, next) << what;
      }
      if (!step.contains("moves") || step["moves"].empty()) continue;
      const sim::Candidate& chosen = panorama.candidates.at(step["action"].get<std::size_t>());
      auto view = step["view_index"].get<std::uint32_t>();
      std::size_t moves = 0;
      while (true) {
        const sim::Action action = step_towards(chosen, view);
        view = view_after(action, view);
        ASSERT_LT(moves, step["moves"].size()) << what;
        const Json& entry = step["moves"][moves++];
        EXPECT_NEAR(view_heading(view).value, entry[1].get<double>(), 1e-9) << what;
        EXPECT_NEAR(view_elevation(view).value, entry[2].get<double>(), 1e-9) << what;
        if (action.index != 0) break;
      }
      EXPECT_EQ(moves, step["moves"].size()) << what;
      EXPECT_EQ(step["moves"].back()[0], graph.id(chosen.viewpoint)) << what;
    }
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::agents
