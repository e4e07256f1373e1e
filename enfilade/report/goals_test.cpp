// Goals of other benchmarks than R2R on the page: plans, outlines in pictures.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "enfilade/report/parts/parts.h"
#include "enfilade/tasks/objects.h"
#include "tests/support/made_run.h"
#include "tests/support/page.h"

namespace enfilade::report {
namespace EN_UNIT {
using testing::decoded;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kReverie =
    R"([{"id": "1_66", "path": ["v0", "v1", "v2"], "objId": 66, "heading": 1.5, "scan": "row", )"
    R"("path_id": 1, "instructions": ["Water the <b>plant</b>."]}])";
constexpr const char* kBoxes = R"({"row_v2": {"66": {"name": "plant#pot", "visible_pos": [12], )"
                               R"("bbox2d": [[270, 190, 100, 100]]}}, "row_v3": {}})";

/// A made-up data set with an episode of REVERIE, whose agent goes to v1 and stops.
class Goals : public ::testing::Test {
 protected:
  void SetUp() override {
    made_.write_pictures();
    make_folder(made_.data() / "reverie");
    write_file_atomically(made_.data() / "reverie/REVERIE_val_unseen.json", kReverie);
    write_file_atomically(made_.data() / "reverie/BBoxes.json", kBoxes);
    data_.emplace(made_.data());
    episodes_ = data_->episodes(tasks::Task::kReverie, "val_unseen");
    run_.agent = "random";
    run_.split = "val_unseen";
    tasks::Trajectory walk;
    walk.points = {{ViewpointIndex(0), {}, {}}, {ViewpointIndex(1), {}, {}}};
    run_.trajectories = std::vector{walk};
  }
  testing::MadeRun made_;
  std::optional<dataset::Dataset> data_;
  tasks::EpisodeSet episodes_;
  ScoredRun run_;
};

TEST_F(Goals, PlansMarkWhoSeesTheObject) {
  parts::BuildingPlans plans(*data_);
  const auto part = parts::plans_part(run_, episodes_, {{"worst", 0}}, plans);
  ASSERT_EQ(part.at("plans").size(), 1U);
  const std::string svg = decoded(part["plans"][0].at("picture").get<std::string>());
  EXPECT_THAT(svg, HasSubstr("sees the plant (1 viewpoint)"));
  EXPECT_THAT(svg, HasSubstr("Water the &lt;b&gt;plant&lt;/b&gt;."));
  EXPECT_THAT(svg, Not(HasSubstr("3 m around it"))) << "that is R2R's goal";
}

TEST_F(Goals, ObjectsAreOutlinedInPictures) {
  const tasks::ObjectBoxes* objects = episodes_.objects.get();
  ASSERT_NE(objects, nullptr);
  const graph::NavGraph& graph = episodes_.graph_of(episodes_.episodes[0]);
  const ViewpointIndex there(2);
  const auto outlines =
      draw::goal_outlines(graph, episodes_.paths[0].goal, there, objects, tasks::Direction{});
  ASSERT_EQ(outlines.size(), 1U);
  const render::View view{ScanIndex(), there, Radians(0), Radians(0)};
  const auto plain = parts::view_uri(*data_, view, {64, 48});
  const auto outlined = parts::view_uri(*data_, view, {64, 48}, outlines);
  ASSERT_TRUE(plain && outlined);
  EXPECT_NE(*plain, *outlined);
}

}  // namespace EN_UNIT
}  // namespace enfilade::report
