// Sessions of the arena, over real sockets.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <algorithm>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "enfilade/arena/wire.h"
#include "enfilade/arena/world.h"
#include "enfilade/core/rng.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score_table.h"
#include "tests/support/served_data.h"

namespace enfilade::service {
namespace EN_UNIT {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class PlayingTest : public ::testing::Test {
 protected:
  struct Play {
    std::string path;
    httplib::Headers headers;
    json begun;
  };

  std::pair<int, json> post(const std::string& target, const std::string& body,
                            const httplib::Headers& headers = {}) {
    const auto answer = served_.client().Post(target, headers, body, "application/json");
    return {answer->status, json::parse(answer->body, nullptr, false)};
  }
  Play begin(const json& wanted) {
    const auto [status, begun] = post("/api/v1/sessions", wanted.dump());
    EXPECT_EQ(status, 201) << begun.dump();
    return {fmt::format("/api/v1/sessions/{}", begun.at("session").get<int>()),
            {{"Enfilade-Session", begun.at("key").get<std::string>()}},
            begun};
  }
  std::pair<int, json> call(const Play& play, const json& body) {
    return post(play.path + "/calls", body.dump(), play.headers);
  }
  static json first_episode() { return {{"split", "val_seen"}, {"episode", "1_0"}}; }
  /// The place that lies straight on: v1 of v0, and so on along the row.
  static std::string farther(const json& observation) {
    for (const json& place : observation.at("places")) {
      if (!place.at("visited").get<bool>()) return place.at("name").get<std::string>();
    }
    return {};
  }

  testing::Served served_;
};

TEST_F(PlayingTest, AnEpisodeIsWalkedToItsGoalAndScored) {
  const Play play = begin(first_episode());
  json state = play.begun;
  EXPECT_EQ(state.at("observation").at("instruction"), "Walk to the end of the hall, path 1.");
  EXPECT_EQ(state.at("calls"), 0);
  EXPECT_TRUE(state.at("ending").is_null());
  EXPECT_EQ(served_.get(play.path + "/result", play.headers)->status, 409);
  const auto early = served_.get(play.path + "/outcome", play.headers);
  EXPECT_EQ(early->status, 409);
  EXPECT_THAT(early->body, Not(HasSubstr("\"v")));
  for (int k = 0; k < 3; ++k) {
    const auto [status, next] = call(
        play, {{"tool", "go_to"}, {"argument", farther(state.at("observation"))}, {"after", k}});
    ASSERT_EQ(status, 200) << next.dump();
    EXPECT_TRUE(next.at("carried_out"));
    state = next;
  }
  state = call(play, {{"answer", "I am there.\nAction: stop"}}).second;
  EXPECT_EQ(state.at("ending"), "stopped");
  EXPECT_EQ(state.at("calls"), 4);
  EXPECT_EQ(call(play, {{"tool", "stop"}}).first, 409) << "it is over";
  const dataset::Dataset data(served_.root() / "data");
  const tasks::EpisodeSet episodes = data.episodes("val_seen");
  auto results = tasks::parse_results(served_.get(play.path + "/result", play.headers)->body,
                                      "result", episodes, tasks::Coverage::kPart);
  ASSERT_EQ(results.trajectories.size(), 1U);
  EXPECT_EQ(results.trajectories[0].points.size(), 4U);
  EXPECT_EQ(
      episodes.graphs->graph(ScanIndex(0)).id(results.trajectories[0].points.back().viewpoint),
      "v3");
  // The outcome is that of the scorer.
  const json outcome = served_.json(play.path + "/outcome", play.headers);
  const tasks::EpisodeSet part = tasks::part_of(episodes, results.trajectories);
  const tasks::ScoreTable score = tasks::compute_score(results, part);
  EXPECT_EQ(outcome.at("scan"), "row");
  EXPECT_EQ(outcome.at("kind"), "end");
  EXPECT_EQ(outcome.at("path"), json({"v0", "v1", "v2", "v3"}));
  EXPECT_EQ(outcome.at("walk"), outcome.at("path"));
  EXPECT_EQ(outcome.at("viewpoints"), json::array());
  EXPECT_EQ(outcome.at("success"), true);
  EXPECT_DOUBLE_EQ(outcome.at("error").get<double>(), score.value(0, "nav_error"));
  EXPECT_DOUBLE_EQ(outcome.at("length").get<double>(), score.value(0, "trajectory_length"));
  EXPECT_DOUBLE_EQ(outcome.at("shortest").get<double>(), score.value(0, "shortest"));
}

TEST_F(PlayingTest, TheOutcomeOfAStopAtTheStartIsNoSuccess) {
  const Play play = begin({{"split", "val_seen"}, {"episode", "2_1"}});
  EXPECT_EQ(call(play, {{"tool", "look"}, {"argument", "left"}}).first, 200);
  EXPECT_EQ(call(play, {{"tool", "stop"}}).first, 200);
  const json outcome = served_.json(play.path + "/outcome", play.headers);
  EXPECT_EQ(outcome.at("walk"), json::array({"v1"})) << "a turn is no step";
  EXPECT_EQ(outcome.at("length"), 0);
  EXPECT_EQ(outcome.at("error"), outcome.at("shortest"));
  EXPECT_EQ(outcome.at("error"), 3.0);
  EXPECT_EQ(outcome.at("success"), false) << "success is nearer than 3 m";
  served_.stop();  // it is replayed, and judged again
  served_.start();
  EXPECT_EQ(served_.json(play.path + "/outcome", play.headers), outcome);
}

TEST_F(PlayingTest, AnEpisodeIsChosenWhereNoneIsNamed) {
  std::set<std::string> chosen;
  for (int k = 0; k < 40; ++k) {
    const Play play = begin({{"split", "val_seen"}});
    chosen.insert(play.begun.at("episode").get<std::string>());
    if (k > 0) continue;
    served_.stop();  // the database has the chosen one
    served_.start();
    EXPECT_EQ(served_.json(play.path, play.headers).at("episode"), play.begun.at("episode"));
  }
  EXPECT_THAT(chosen, ::testing::Each(::testing::AnyOf("1_0", "1_1", "2_0", "2_1", "3_0", "3_1")));
  EXPECT_GT(chosen.size(), 1U);
}

TEST_F(PlayingTest, ASplitWithoutEpisodesHasNoSessions) {
  write_file_atomically(served_.root() / "data/r2r/R2R_train.json", "[]");
  served_.restart_with(R"({"name": "open", "split": "val_seen"})");
  const auto [status, answer] = post("/api/v1/sessions", json{{"split", "train"}}.dump());
  EXPECT_EQ(status, 404);
  EXPECT_THAT(answer.dump(), HasSubstr("split train of r2r has no episode"));
}

// What the arena's session says to the same calls, whoever carries them.
TEST_F(PlayingTest, SaysWhatTheSessionItselfSays) {
  const dataset::Dataset data(served_.root() / "data");
  arena::GraphWorld world(std::make_shared<const tasks::EpisodeSet>(data.episodes("val_seen")));
  const auto session = world.start_on_graph(0);
  const Play play = begin(first_episode());
  json state = play.begun;
  Rng rng(3);
  for (int k = 0; !session->ending(); ++k) {
    const json here = json::parse(to_json(session->observation()));
    ASSERT_EQ(state.at("observation"), here) << k;
    const auto& tools = session->observation().tools;
    const arena::ToolUse& tool = tools[rng.below(k < 8 ? tools.size() - 1 : tools.size())];
    json body{{"tool", arena::name_of(tool.tool)}};
    arena::Call same{std::string(arena::name_of(tool.tool)), ""};
    if (!tool.allowed.empty()) {
      same.argument = tool.allowed[rng.below(tool.allowed.size())];
      body["argument"] = same.argument;
    }
    if (k == 3) {  // a restart in the middle changes nothing
      served_.stop();
      served_.start();
      EXPECT_EQ(served_.json(play.path, play.headers).at("observation"), here);
    }
    state = call(play, body).second;
    session->call(same);
  }
  EXPECT_EQ(state.at("ending"), arena::name_of(*session->ending()));
}

TEST_F(PlayingTest, ACallThatIsSentAgainIsNotCarriedOutTwice) {
  const Play play = begin(first_episode());
  const json body{
      {"tool", "go_to"}, {"argument", farther(play.begun.at("observation"))}, {"after", 0}};
  EXPECT_EQ(call(play, body).first, 200);
  served_.stop();  // the answer was lost with the server
  served_.start();
  const auto [status, refused] = call(play, body);
  EXPECT_EQ(status, 409);
  EXPECT_THAT(refused.dump(), HasSubstr("after: 0, but the session has had 1 calls"));
  EXPECT_EQ(served_.json(play.path, play.headers).at("calls"), 1);
}

TEST_F(PlayingTest, MistakesAreToldAndEndItAtTheirLimit) {
  json wanted = first_episode();
  wanted["mistakes"] = 3;
  const Play play = begin(wanted);
  const json first = call(play, {{"tool", "go_to"}, {"argument", "Z"}}).second;
  EXPECT_FALSE(first.at("carried_out"));
  EXPECT_THAT(first.at("observation").at("told").get<std::string>(), HasSubstr("Z"));
  EXPECT_EQ(first.at("observation").at("step"), 0);
  EXPECT_EQ(call(play, {{"answer", "no idea"}}).second.at("mistakes"), 2);
  EXPECT_EQ(call(play, {{"tool", "fly"}}).second.at("ending"), "mistakes");
  served_.stop();
  served_.start();
  EXPECT_EQ(served_.json(play.path, play.headers).at("ending"), "mistakes");
}

TEST_F(PlayingTest, HiddenGoalsStayHidden) {
  const Play play = begin({{"split", "test"}, {"episode", "1_0"}});
  std::string all = play.begun.dump();
  json state = play.begun;
  for (int k = 0; k < 5; ++k) {
    const std::string to = farther(state.at("observation"));
    if (to.empty()) break;
    state = call(play, {{"tool", "go_to"}, {"argument", to}}).second;
    all += state.dump();
  }
  all += call(play, {{"tool", "stop"}}).second.dump();
  EXPECT_THAT(all, Not(HasSubstr("goal")));
  EXPECT_THAT(all, Not(HasSubstr("success")));
  for (int v = 0; v < 6; ++v) {  // viewpoints have letters
    EXPECT_THAT(all, Not(HasSubstr(fmt::format("\"v{}\"", v))));
  }
  EXPECT_EQ(served_.get(play.path + "/result", play.headers)->status, 200);
  const auto outcome = served_.get(play.path + "/outcome", play.headers);
  EXPECT_EQ(outcome->status, 404);
  EXPECT_THAT(outcome->body, HasSubstr("split test of r2r has hidden goals"));
  EXPECT_THAT(outcome->body, Not(HasSubstr("\"v")));
}

// The data set has the goals that a phase keeps secret.
TEST_F(PlayingTest, OutcomesOfASecretPhaseAreRefused) {
  write_file_atomically(served_.root() / "kept.json",
                        to_json(testing::row_annotations("val_seen", true)));
  served_.restart_with(R"({"name": "secret", "split": "val_seen", "annotations": "kept.json"})");
  const Play play = begin(first_episode());
  EXPECT_EQ(call(play, {{"tool", "stop"}}).first, 200);
  const auto outcome = served_.get(play.path + "/outcome", play.headers);
  EXPECT_EQ(outcome->status, 404);
  EXPECT_THAT(outcome->body, HasSubstr("hidden goals"));
  EXPECT_THAT(outcome->body, Not(HasSubstr("\"v")));
}

TEST_F(PlayingTest, SessionsOfOthersAreAsIfThereWereNone) {
  const Play mine = begin(first_episode()), yours = begin(first_episode());
  EXPECT_EQ(served_.get(mine.path)->status, 401);
  const auto other = served_.get(mine.path, yours.headers);
  const auto none = served_.get("/api/v1/sessions/999", yours.headers);
  EXPECT_EQ(other->status, 404);
  EXPECT_EQ(none->status, 404);
  EXPECT_EQ(other->body, none->body);
  EXPECT_EQ(post(mine.path + "/calls", R"({"tool": "stop"})", yours.headers).first, 404);
  for (const char* rest : {"/result", "/outcome", "/pictures/strip/0"}) {
    EXPECT_EQ(served_.get(mine.path + rest, yours.headers)->status, 404) << rest;
  }
  EXPECT_EQ(served_.json(mine.path, mine.headers).at("calls"), 0);
  // The key is nowhere in the database, of which people make copies.
  const std::string key = mine.headers.begin()->second;
  EXPECT_THAT(testing::content_of(served_.config().database), Not(HasSubstr(key)));
}

TEST_F(PlayingTest, PicturesAreOfWhatIsSeenNow) {
  const Play play = begin(first_episode());
  const auto strip = served_.get(play.path + "/pictures/strip/0?size=128", play.headers);
  ASSERT_EQ(strip->status, 200) << strip->body;
  EXPECT_EQ(strip->get_header_value("Content-Type"), "image/jpeg");
  EXPECT_THAT(strip->body, StartsWith("\xFF\xD8"));
  const std::size_t places = play.begun.at("observation").at("places").size();
  for (std::size_t k = 0; k <= places; ++k) {
    const auto target = fmt::format("{}/pictures/places/{}?size=64", play.path, k);
    EXPECT_EQ(served_.get(target, play.headers)->status, k < places ? 200 : 404) << k;
  }
  EXPECT_EQ(served_.get(play.path + "/pictures/strip/0?size=5", play.headers)->status, 400);
  EXPECT_EQ(served_.get(play.path + "/pictures/film/0", play.headers)->status, 404);
}

TEST_F(PlayingTest, BadRequestsAreToldWhatIsAllowed) {
  const std::pair<json, std::string> wrong[]{
      {{{"episode", "1_0"}}, "split"},
      {{{"split", "nowhere"}, {"episode", "1_0"}}, "no split nowhere"},
      {{{"split", "val_seen"}, {"episode", "7_0"}}, "no episode"},
      {{{"split", "val_seen"}, {"episode", "1_0"}, {"task", "chess"}}, "chess"},
      {{{"split", "val_seen"}, {"episode", "1_0"}, {"steps", 0}}, "steps: not a whole number"},
      {{{"split", "val_seen"}, {"episode", "1_0"}, {"mistakes", "9"}}, "mistakes"},
      {{{"split", 3}, {"episode", "1_0"}, {"steps", 0}, {"mistakes", "9"}},
       "split: must be there, and a text; steps: not a whole number from 1 to 1000; "
       "mistakes: not a whole number from 1 to 1000"}};
  for (const auto& [body, said] : wrong) {
    const auto [status, answer] = post("/api/v1/sessions", body.dump());
    EXPECT_THAT(status, ::testing::AnyOf(400, 404, 422)) << body.dump();
    EXPECT_THAT(answer.dump(), HasSubstr(said)) << body.dump();
  }
  const Play play = begin(first_episode());
  for (const std::string& body : {std::string("[]"), std::string("{"), std::string("{}"),
                                  std::string(R"({"tool": "stop", "answer": "Action: stop"})"),
                                  std::string(R"({"tool": "stop", "after": -1})"),
                                  json{{"tool", std::string(300, 'x')}}.dump()}) {
    EXPECT_EQ(post(play.path + "/calls", body, play.headers).first, 400) << body;
  }
  EXPECT_EQ(served_.json(play.path, play.headers).at("calls"), 0) << "none of them was a call";
  // What a model says is data: it comes back as text, and as nothing else.
  const json said =
      call(play, {{"tool", "go_to"}, {"argument", "<script>alert(1)</script>"}}).second;
  EXPECT_FALSE(said.at("carried_out"));
}

TEST_F(PlayingTest, ManyWalkAtOnce) {
  constexpr int kPlays = 64, kThreads = 8;
  std::vector<std::thread> threads;
  std::vector<int> wrong(kThreads, 0);
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      httplib::Client client("127.0.0.1", served_.port());
      for (int k = t; k < kPlays; k += kThreads) {
        const auto begun =
            client.Post("/api/v1/sessions", first_episode().dump(), "application/json");
        json state = json::parse(begun->body);
        const httplib::Headers headers{{"Enfilade-Session", state.at("key").get<std::string>()}};
        const std::string path = fmt::format("/api/v1/sessions/{}", state.at("session").get<int>());
        for (int step = 0; step < 3; ++step) {
          const json body{{"tool", "go_to"}, {"argument", farther(state.at("observation"))}};
          state = json::parse(
              client.Post(path + "/calls", headers, body.dump(), "application/json")->body);
        }
        wrong[static_cast<std::size_t>(t)] +=
            state.value("calls", 0) == 3 && state.value("mistakes", 1) == 0 ? 0 : 1;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_THAT(wrong, ::testing::Each(0));
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
