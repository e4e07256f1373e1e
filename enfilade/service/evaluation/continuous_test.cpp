// Phases of continuous benchmarks, over real sockets: checked, scored and ranked, and their goals
// kept.
#include <gmock/gmock.h>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/continuous/navigation_mesh.h"
#include "enfilade/core/gzip.h"
#include "enfilade/service/evaluation/submissions.h"
#include "enfilade/tasks/score_table.h"
#include "tests/support/made_meshes.h"
#include "tests/support/refusal.h"
#include "tests/support/served_data.h"

namespace enfilade::service {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::Not;
using namespace testing;  // NOLINT(google-build-using-namespace)
using tests::refusal;
namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kSecret =
    R"({"name": "free", "split": "test", "task": "r2r-ce", "annotations": "walks.json.gz"%})";

std::string phase(const std::string& more = "", std::string text = kSecret) {
  return text.replace(text.find('%'), 1, more);
}

/// The row of viewpoints, 1 m from one to the next, in a hall of 8 m by 2 m.
class ContinuousPhases : public ::testing::Test {
 protected:
  ContinuousPhases() {
    const mesh::RayTracer tracer(
        std::make_shared<const mesh::Mesh>(mesh::testing::Maker().room(-1, -1, 7, 1).mesh));
    for (const char* benchmark : {"r2r-ce", "rxr-ce"}) {
      make_folder(data() / "navmesh" / benchmark);
      continuous::save_navigation_mesh(mesh::make_floor_polygons(tracer),
                                       data() / "navmesh" / benchmark / "row.navmesh");
    }
    for (const char* folder : {"vlnce", "vlnce/rxr"}) make_folder(data() / folder);
    episodes_.split = "test";
    for (const std::int64_t id : {1, 2}) {
      tasks::ContinuousEpisode e;
      e.id = id;
      e.trajectory_id = id;
      e.scene = "mp3d/row/row.glb";
      e.start = {0, 0, 0};
      e.rotation = tasks::StartRotation::of(degrees(90));
      e.goals = {{{id == 1 ? 5.0 : 4.0, 0, 0}, 3}};
      e.instruction.text = "Walk down the hall.";
      e.instruction.id = std::to_string(id);
      e.reference_path.emplace();
      for (double x = 0; x <= e.goals->front().position.x; x += 0.25) {
        e.reference_path->push_back({x, 0, 0});
      }
      episodes_.episodes.push_back(e);
    }
    write(served_.root() / "walks.json.gz", episodes_);
    write(data() / "vlnce/val_seen.json.gz", episodes_);
    tasks::ContinuousEpisodes hidden = episodes_;
    for (tasks::ContinuousEpisode& e : hidden.episodes) {
      e.goals.reset();
      e.reference_path.reset();
    }
    write(data() / "vlnce/test.json.gz", hidden);
    write(data() / "vlnce/test_guide.json.gz", hidden);
  }

  static void write(const fs::path& file, const tasks::ContinuousEpisodes& episodes) {
    write_file_atomically(file, gzip(to_json(episodes), 6));
  }
  fs::path data() const { return served_.root() / "data"; }
  std::shared_ptr<const continuous::Buildings> buildings() const {
    return std::make_shared<const continuous::Buildings>(data() / "navmesh/r2r-ce");
  }
  std::vector<tasks::ContinuousResult> walks(const std::string& agent) const {
    const auto walker = agents::make_continuous_agent(agent);
    return agents::run_continuous(*walker, episodes_, buildings(), {.batch_size = 2});
  }
  std::string results(const std::string& agent) const {
    return to_json(walks(agent), episodes_, tasks::ContinuousForm::kR2r);
  }
  void serve(const std::string& phases) {
    served_.restart_with(phases);
    organiser_ = served_.organiser();
    team_ = served_.team("A");
  }
  /// The organisers' view of a submission when it is scored.
  json score(const std::string& results, const std::string& method = "m") {
    const auto taken = served_.submit(team_, "free", results, method);
    EXPECT_EQ(taken->status, 202) << taken->body;
    if (taken->status != 202) return {};
    return served_.scored(organiser_, json::parse(taken->body).at("id").get<std::int64_t>());
  }
  std::string refused(const std::string& results) {
    const auto answer = served_.submit(team_, "free", results);
    EXPECT_EQ(answer->status, 422) << answer->body;
    return answer->body;
  }

  Served served_;
  httplib::Headers organiser_, team_;
  tasks::ContinuousEpisodes episodes_;
};

TEST_F(ContinuousPhases, OpenGoalsAreScoredAsTheProgramScoresThem) {
  serve(phase("", R"({"name": "free", "split": "val_seen", "task": "r2r-ce"%})"));
  score(results("forward"), "forward");
  score(results("shortest"), "shortest");
  const json board = served_.json("/api/v1/leaderboards/free?all=1");
  EXPECT_EQ(board.at("task"), "r2r-ce");
  EXPECT_EQ(board.at("scorer"), "vlnce");
  EXPECT_EQ(board.at("primary"), "spl");
  std::vector<std::string> names;
  for (const json& column : board.at("columns"))
    names.push_back(column.at("name").get<std::string>());
  EXPECT_EQ(names, (std::vector<std::string>{"spl", "success", "oracle_success", "distance_to_goal",
                                             "ndtw", "sdtw", "path_length"}));
  ASSERT_EQ(board.at("rows").size(), 2U);
  EXPECT_EQ(board.at("rows")[0].at("method"), "shortest");
  for (const json& row : board.at("rows")) {
    const auto walked = walks(row.at("method").get<std::string>());
    const tasks::Benchmark& benchmark = tasks::benchmark("r2r-ce");
    const tasks::ScoreTable scores =
        agents::compute_score(walked, episodes_, *buildings(), {}, benchmark, benchmark.scorer({}));
    for (const tasks::Measure& measure : scores.scorer->columns) {
      const std::string name(measure.name);
      // The files hold single precision, the walks too: equal but for the last digits of a sum.
      EXPECT_NEAR(row.at("means").at(name).at("mean").get<double>(), scores.mean(name).mean, 1e-6)
          << name;
    }
  }
  EXPECT_EQ(board.at("rows")[0].at("means").at("success").at("mean"), 1.0);
  const std::string sheet = served_.get("/api/v1/leaderboards/free?format=csv")->body;
  EXPECT_THAT(sheet, HasSubstr("team,method,created,spl,spl_low,spl_high,success,"));
  const json listed = served_.json("/api/v1/phases").at("phases").at(0);
  EXPECT_EQ(listed.at("task_title"), "R2R-CE");
  EXPECT_EQ(listed.at("episodes"), 2);
}

TEST_F(ContinuousPhases, SecretGoalsStaySecretInBothWorlds) {
  // A data set that has the goals by mistake does not show them either.
  write(data() / "vlnce/test.json.gz", episodes_);
  write_file_atomically(data() / "r2r/R2R_test.json", to_json(row_annotations("test", true)));
  serve(phase());
  const json free = served_.json("/api/v1/continuous/test/episodes");
  EXPECT_EQ(free.at("goals_hidden"), true) << free;
  EXPECT_EQ(free.at("episodes").size(), 2U);
  EXPECT_THAT(free.dump(), Not(HasSubstr("goals\":[")));
  EXPECT_THAT(free.dump(), Not(HasSubstr("path")));
  // Nor those of another split with the same goals.
  const json seen = served_.json("/api/v1/continuous/val_seen/episodes");
  EXPECT_EQ(seen.at("goals_hidden"), true) << seen;
  EXPECT_THAT(seen.dump(), Not(HasSubstr("path")));
  // R2R's paths of this split end where the walks should.
  EXPECT_EQ(served_.json("/api/v1/splits/test/episodes").at("goals_hidden"), true);
  const json scored = score(results("shortest"));
  EXPECT_EQ(scored.at("means").at("success").at("mean"), 1.0) << scored;
  const json received = served_.json("/api/v1/submissions/" + scored.at("id").dump(), team_);
  EXPECT_EQ(received.at("state"), "received");
  EXPECT_FALSE(received.contains("means"));
  EXPECT_EQ(served_.get("/api/v1/leaderboards/free", team_)->status, 403);
  // Five viewpoints in reach of the one start.
  const json leakage = served_.json("/api/v1/phases").at("phases").at(0).at("leakage");
  EXPECT_EQ(leakage.at("goal_bits"), std::ceil(std::log2(5)));
}

TEST_F(ContinuousPhases, PhasesOfBothWorldsShareTheirGoals) {
  serve(phase() + R"(, {"name": "graph", "split": "test", "annotations": "secret.json"})");
  const json phases = served_.json("/api/v1/phases").at("phases");
  for (const json& one : phases) {
    EXPECT_EQ(one.at("leakage").at("phases"), (json{"free", "graph"}));
  }
}

TEST_F(ContinuousPhases, AWalkHasTheStepsOfABody) {
  serve(phase());
  auto jumping = walks("shortest");
  jumping[1].positions.back() = {6, 0, 0};
  const auto text = [this](const std::vector<tasks::ContinuousResult>& all) {
    return to_json(all, episodes_, tasks::ContinuousForm::kR2r);
  };
  EXPECT_THAT(refused(text(jumping)), HasSubstr("step-too-long"));
  EXPECT_THAT(refused(text(jumping)), HasSubstr("episode 2, pose"));
  // A slide around a corner: longer than a step, shorter than two.
  auto sliding = walks("shortest");
  sliding[1].positions.at(1).y += 0.13F;
  EXPECT_NO_THROW(score(text(sliding)));
  // Each as long as the longest slide.
  auto striding = walks("shortest");
  for (std::size_t k = 0; k < striding[1].positions.size(); ++k) {
    striding[1].positions[k].x = striding[1].positions[0].x + 0.5F * static_cast<float>(k);
  }
  EXPECT_THAT(refused(text(striding)), HasSubstr("0.500 m from the pose before"));
  auto long_one = walks("shortest");
  long_one[0].actions.assign(501, 2);
  long_one[0].positions.assign(502, long_one[0].positions[0]);
  long_one[0].headings.clear();
  long_one[0].collided.clear();
  for (int k = 0; k < 502; ++k) long_one[0].headings.push_back(wrap_heading(degrees(90 - 15 * k)));
  EXPECT_THAT(refused(text(long_one)), HasSubstr("501 actions; R2R-CE allows 500"));
  auto half = walks("shortest");
  half.pop_back();
  EXPECT_THAT(refused(text(half)), HasSubstr("no walk for 1 of the 2 episodes"));
  EXPECT_THAT(refused("[]"), HasSubstr("error"));
}

TEST_F(ContinuousPhases, RoomAcrossRoomTakesItsFormAndRanksByNdtw) {
  // The expert of the first episode stays where it is: nDTW compares with it, not with the path.
  tasks::ExpertWalks experts;
  experts["1"] = {{{0, 0, 0}}, 0, {0}};
  write_file_atomically(served_.root() / "experts.json", to_json(experts));
  serve(phase("", R"({"name": "free", "split": "test", "task": "rxr-ce",
                      "annotations": "walks.json.gz", "experts": "experts.json"%})"));
  EXPECT_EQ(served_.json("/api/v1/phases").at("phases").at(0).at("primary"), "ndtw");
  const auto walked = walks("shortest");
  const json scored = score(to_json(walked, episodes_, tasks::ContinuousForm::kRxr)).at("means");
  const auto mean = [&](const tasks::ExpertWalks& with) {
    double sum = 0;
    for (const auto& one : agents::score_continuous_walks(walked, episodes_, *buildings(), with)) {
      sum += one.ndtw / 2;
    }
    return sum;
  };
  // RxR's form leaves out poses at one place, which nDTW counts: turns on the spot.
  EXPECT_NEAR(scored.at("ndtw").at("mean").get<double>(), mean(experts), 0.02);
  EXPECT_GT(mean({}) - mean(experts), 0.2);
}

TEST_F(ContinuousPhases, NearCopiesAreToldToOrganisers) {
  const auto first = walks("shortest");
  auto second = first;
  for (Vec3f& p : second[0].positions) p.x += 0.01F;
  EXPECT_EQ(evaluation::count_differing(evaluation::trajectory_ends(first),
                                        evaluation::trajectory_ends(walks("forward"))),
            2U);
  second[0].actions.back() = 1;  // it did not stop
  EXPECT_EQ(evaluation::count_differing(evaluation::trajectory_ends(first),
                                        evaluation::trajectory_ends(second)),
            1U);
}

TEST_F(ContinuousPhases, FilesOfPhasesHaveClearFaults) {
  const auto fault = [](const std::string& text) {
    return refusal([&] { parse_phases(R"({"phases": [)" + text + "]}", "phases.json"); });
  };
  EXPECT_EQ(fault(phase()), "accepted");
  EXPECT_THAT(fault(phase(R"(, "scorer": "duet")")), HasSubstr("\"duet\", not one of vlnce"));
  EXPECT_THAT(fault(phase(R"(, "primary": "distance_to_goal")")),
              HasSubstr("not one of spl, success, oracle_success, ndtw, sdtw"));
  EXPECT_THAT(fault(R"({"name": "a", "split": "test", "task": "r2r-ce", "experts": "e.json"})"),
              HasSubstr("experts-without-use"));
  EXPECT_THAT(fault(R"({"name": "a", "split": "test", "task": "r2r-de"})"),
              HasSubstr("soon, r2r-ce, rxr-ce"));
  EXPECT_THAT(
      fault(phase() + R"(, {"name": "graph", "split": "test"})"),
      HasSubstr("\"test\" has secret goals in phase \"free\"; give this phase \"annotations\""));
}

TEST_F(ContinuousPhases, ASiteSaysWhatKeepsAPhaseFromBeingScored) {
  const auto fault = [this](const std::string& list) {
    return refusal([&] {
      Site::open(data(), parse_phases(R"({"phases": [)" + list + "]}",
                                      (served_.root() / "phases.json").string()));
    });
  };
  const std::string open = R"({"name": "a", "split": "%", "task": "r2r-ce"})";
  EXPECT_THAT(fault(phase("test", open)), HasSubstr("phase a cannot be scored"));
  EXPECT_THAT(fault(phase("val_unseen", open)), HasSubstr("no episodes of r2r-ce val_unseen"));
  write_file_atomically(data() / "goals.json", to_json(episodes_));
  const std::string inside = R"({"name": "a", "split": "test", "task": "r2r-ce",
                                 "annotations": ")" +
                             (data() / "goals.json").string() + "\"}";
  EXPECT_THAT(fault(inside), HasSubstr("goals-in-data-set"));
  auto off = episodes_;
  off.episodes[0].goals->front().position = {50, 0, 0};
  write(data() / "vlnce/val_seen.json.gz", off);
  EXPECT_THAT(fault(phase("val_seen", open)), HasSubstr("goal-off-floor"));
  off = episodes_;
  off.episodes[1].scene = "mp3d/elsewhere/elsewhere.glb";
  write(data() / "vlnce/val_seen.json.gz", off);
  EXPECT_THAT(fault(phase("val_seen", open)), HasSubstr("elsewhere"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
