// Gathering, keeping and ordering walks; the whole training, in two small buildings.
#include <ATen/ATen.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <filesystem>
#include <memory>
#include <set>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/neural/continuous/episode_file.h"
#include "enfilade/neural/continuous/gatherer.h"
#include "enfilade/neural/continuous_agent.h"
#include "enfilade/neural/device.h"
#include "enfilade/neural/trained_agent.h"
#include "tests/support/furnished_room.h"
#include "tests/support/made_meshes.h"
#include "tests/support/small_training.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::neural::continuous {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// Two rooms with furniture, and a bare one with a pillar.
class Buildings {
 public:
  Buildings() {
    add("rooms", tests::furnished_rooms());
    add("bare", mesh::testing::Maker().room(0, 0, 7.5F, 5).box({3, 2, 0}, {4, 3, 2.6F}).mesh);
    std::vector<enfilade::continuous::Building> made;
    for (const auto& [scan, scene] : scenes_) {
      made.push_back({scan, std::make_shared<const enfilade::continuous::NavigationMesh>(
                                make_floor_polygons(scene->tracer()))});
    }
    buildings = std::make_shared<const enfilade::continuous::Buildings>(std::move(made));
  }

  std::shared_ptr<const enfilade::continuous::Buildings> buildings;
  /// With random weights: walls of other colours give other features.
  ContinuousSight sight() const {
    return {.scene_of = [this](const std::string& scan) { return scenes_.at(scan); },
            .encoder = {.name = "home", .weights = {}, .seed = 1},
            .threads = 1};
  }

 private:
  void add(const std::string& scan, mesh::Mesh mesh) {
    scenes_[scan] =
        enfilade::continuous::Scene::photographed(std::make_shared<const mesh::RayTracer>(
            std::make_shared<const mesh::Mesh>(std::move(mesh))));
  }
  std::map<std::string, std::shared_ptr<const enfilade::continuous::Scene>> scenes_;
};

tasks::ContinuousEpisode episode(std::int64_t id, const std::string& scan, const std::string& text,
                                 Vec3d start, double heading, Vec3d way, Vec3d goal) {
  tasks::ContinuousEpisode e;
  e.id = id;
  e.trajectory_id = id;
  e.scene = fmt::format("made/{0}/{0}.glb", scan);
  e.start = start;
  e.rotation = tasks::StartRotation::of(degrees(heading));
  e.goals = {{.position = goal, .radius = 3}};
  e.reference_path = {start, way, goal};
  e.instruction.text = text;
  return e;
}

tasks::ContinuousEpisodes episodes() {
  tasks::ContinuousEpisodes all;
  all.split = "train";
  all.file = "made.json";
  all.episodes = {
      episode(1, "rooms", "go to the bed", {.6, .6, 0}, 0, {4.05, 2.5, 0}, {5.1, 1.5, 0}),
      episode(2, "rooms", "go past the picture", {7, 3, 0}, 270, {4.05, 2.5, 0}, {1.5, 4.4, 0}),
      episode(3, "bare", "walk left around the pillar", {.5, 2.5, 0}, 90, {3.5, 4, 0}, {7, 2.5, 0}),
      episode(4, "bare", "walk right around the pillar", {.5, 2.5, 0}, 90, {3.5, 1, 0}, {7, 1, 0}),
      episode(5, "bare", "stop in the corner", {6.5, 4.5, 0}, 180, {6.5, 2, 0}, {1, .5, 0})};
  return all;
}

models::TrainConfig small_config() {
  models::TrainConfig config = recipe(models::AgentKind::kSeq2SeqCe, models::Recipe::kSmall);
  config.seq2seq_ce = {.word_embedding = 8,
                       .sentence = 16,
                       .picture = 16,
                       .depth = 16,
                       .action_embedding = 8,
                       .hidden = 32,
                       .sets = 2,
                       .set_walks = 5,
                       .epochs = 2};
  config.batch_size = 2;
  config.max_steps = 60;
  config.least_count = 1;
  config.checkpoint_every = 4;
  config.validation = {};
  fix_updates(config, 5);
  return config;
}

class SeesTwoBuildings : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    set_threads(1);
    world_ = std::make_unique<Buildings>();
  }
  static void TearDownTestSuite() { world_.reset(); }

  TrainingData data(const models::TrainConfig& config,
                    const ContinuousSight& sight = world_->sight()) const {
    auto own = std::make_shared<ContinuousData>();
    own->setup = agents::continuous_setup("r2r-ce");
    own->training = episodes();
    own->buildings = world_->buildings;
    own->sight = sight;
    TrainingData all;
    if (config.network.inputs.vision) all.fingerprint.features = SightEncoder(sight).info();
    all.fingerprint.add(own->training);
    all.episodes = std::shared_ptr<const ContinuousData>(own);
    return all;
  }
  std::vector<tasks::ContinuousResult> walk(agents::ContinuousAgent& agent,
                                            const tasks::ContinuousEpisodes& in,
                                            std::size_t batch = 64) const {
    return agents::run_continuous(
        agent, in, world_->buildings,
        {.batch_size = batch,
         .seed = 7,
         .simulator = enfilade::continuous::SimulatorConfig::room_to_room()});
  }
  fs::path folder(const std::string& name) const { return folder_.path() / name; }

  static std::unique_ptr<Buildings> world_;
  tests::TemporaryFolder folder_{"seq2seq_ce"};
};
std::unique_ptr<Buildings> SeesTwoBuildings::world_;

/// What a walker is made of.
struct Parts {
  models::TrainConfig config = small_config();
  models::InstructionWords words{
      tasks::Vocabulary::build(std::vector<std::string>{"go to the bed past picture walk"}, 1)};
  std::optional<CeNetwork> network;
  std::optional<SightEncoder> sight;

  explicit Parts(const ContinuousSight& eyes) {
    sight.emplace(eyes);
    config.network.vocabulary = words.vocabulary()->size();
    config.network.features = sight->info().dimensions;
    network.emplace(sizes_of(config), 1);
  }
  GathererParts parts() { return {&*network, &words, &config.network, &*sight}; }
};

TEST_F(SeesTwoBuildings, TheTeacherAloneWalksAsTheExpert) {
  Parts parts(world_->sight());
  const tasks::ContinuousEpisodes all = episodes();
  Gatherer gatherer(parts.parts(), {.teacher_share = 1}, all);
  const auto walks = walk(gatherer, all);
  const auto expert = agents::make_continuous_agent("reference");
  const auto experts = walk(*expert, all);
  ASSERT_EQ(walks.size(), 5U);
  for (std::size_t i = 0; i < walks.size(); ++i) {
    EXPECT_EQ(walks[i], experts[i]) << i;
    const RecordedEpisode& kept = gatherer.walks()[i];
    EXPECT_EQ(kept.teacher, experts[i].actions) << i;
    ASSERT_EQ(kept.previous.size(), kept.teacher.size());
    EXPECT_EQ(kept.previous[0], kNoAction);
    for (std::size_t t = 1; t < kept.previous.size(); ++t) {
      EXPECT_EQ(kept.previous[t], 1 + kept.teacher[t - 1]);
    }
    EXPECT_EQ(kept.seen.depth.size(), kept.teacher.size() * kDepthSize);
    EXPECT_EQ(kept.seen.pictures.size(), kept.teacher.size() * parts.config.network.features);
  }
}

TEST_F(SeesTwoBuildings, MixedWalksAreTheSameAgainAndAreNotTheTeachers) {
  Parts parts(world_->sight());
  const tasks::ContinuousEpisodes all = episodes();
  const auto gathered = [&] {
    Gatherer gatherer(parts.parts(), {.teacher_share = .5}, all);
    walk(gatherer, all);
    return gatherer.walks();
  };
  const auto first = gathered(), second = gathered();
  std::size_t own = 0, steps = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].seen.pictures, second[i].seen.pictures) << i;
    EXPECT_EQ(first[i].seen.depth, second[i].seen.depth) << i;
    EXPECT_EQ(first[i].previous, second[i].previous) << i;
    EXPECT_EQ(first[i].teacher, second[i].teacher) << i;
    for (std::size_t t = 1; t < first[i].previous.size(); ++t, ++steps) {
      if (first[i].previous[t] != 1 + first[i].teacher[t - 1]) ++own;
    }
  }
  // Half are the network's own; of these, which are nearly even, a quarter agrees by chance. Stops
  // end a walk, so the share is of few steps: 3/8 expected, about 30 steps or more.
  EXPECT_GT(own, steps / 8);
  EXPECT_LT(own, steps * 5 / 8);
}

// However a walker strays, it is told to stop at the end of its path and nowhere else.
TEST_F(SeesTwoBuildings, TheTeacherSaysStopAtTheGoalAlone) {
  Parts parts(world_->sight());
  const tasks::ContinuousEpisodes all = episodes();
  Gatherer gatherer(parts.parts(), {.teacher_share = .8}, all);
  const auto walks = walk(gatherer, all);
  std::size_t stops = 0, others = 0;
  for (std::size_t i = 0; i < walks.size(); ++i) {
    const Vec3d goal = all.episodes[i].goals->front().position;
    const RecordedEpisode& kept = gatherer.walks()[i];
    for (std::size_t t = 0; t < kept.teacher.size(); ++t) {
      const double metres = length(goal - to_double(walks[i].positions[t]));
      // Half a metre, and 2 cm that the floor may be off the goal's point.
      if (kept.teacher[t] == 0) {
        EXPECT_LT(metres, .52) << i << " " << t;
      }
      (kept.teacher[t] == 0 ? stops : others) += 1;
    }
  }
  EXPECT_GT(others, 5U);
  RecordProperty("stops", static_cast<int>(stops));
}

TEST_F(SeesTwoBuildings, DepthIsTheRoomsAndNothingIsSeenTwice) {
  Parts parts(world_->sight());
  tasks::ContinuousEpisodes one = episodes();
  one.episodes = {episode(1, "bare", "", {.5, 2.5, 0}, 90, {2, 2.5, 0}, {2.5, 2.5, 0})};
  Gatherer gatherer(parts.parts(), {.teacher_share = 1}, one);
  walk(gatherer, one);
  const RecordedEpisode& kept = gatherer.walks()[0];
  // The pillar's face is 2.5 m ahead, at x = 3: 2.5 / 10 of 255, to the rounding of a byte.
  const std::size_t middle = 8 * kDepthCells + 8;
  EXPECT_NEAR(kept.seen.depth[middle], 255 * .25, .51);
  // A step of 0.25 m nearer.
  ASSERT_EQ(kept.teacher[0], 1);
  EXPECT_NEAR(kept.seen.depth[kDepthSize + middle], 255 * .225, .51);
}

TEST_F(SeesTwoBuildings, ABuildingIsOpenedOnceHoweverManyAreLookedAtAtOnce) {
  std::vector<enfilade::continuous::Building> made;
  tasks::ContinuousEpisodes in = episodes();
  in.episodes.clear();
  const std::size_t bare = world_->buildings->at("bare");
  for (const char* scan : {"a", "b", "c", "d", "e", "f"}) {
    made.push_back({scan, std::shared_ptr<const enfilade::continuous::Floor>(
                              world_->buildings, &world_->buildings->floor(bare))});
    in.episodes.push_back(episode(1, scan, "", {.5, 2.5, 0}, 90, {2, 2.5, 0}, {2.5, 2.5, 0}));
  }
  std::map<std::string, int> opened;
  ContinuousSight sight = world_->sight();
  sight.scene_of = [&opened, all = sight.scene_of](const std::string& scan) {
    ++opened[scan];
    return all("bare");
  };
  Parts parts(sight);
  Gatherer gatherer(parts.parts(), {.teacher_share = 1}, in);
  agents::run_continuous(gatherer, in,
                         std::make_shared<const enfilade::continuous::Buildings>(made),
                         {.simulator = enfilade::continuous::SimulatorConfig::room_to_room()});
  EXPECT_EQ(opened.size(), 6U);
  for (const auto& [scan, times] : opened) EXPECT_EQ(times, 1) << scan;
}

TEST_F(SeesTwoBuildings, WalksAreReadBack) {
  Parts parts(world_->sight());
  const tasks::ContinuousEpisodes all = episodes();
  Gatherer gatherer(parts.parts(), {.teacher_share = .5}, all);
  walk(gatherer, all);
  std::vector<RecordedEpisode> walks = gatherer.walks();
  for (std::size_t i = 0; i < walks.size(); ++i) walks[i].episode = 10 + i;
  const fs::path file = folder("walks.safetensors");
  write_episodes(file, walks, "abc");
  const std::size_t width = parts.config.network.features;
  const EpisodeFile read(file, width);
  EXPECT_EQ(read.weights(), "abc");
  ASSERT_EQ(read.size(), walks.size());
  for (std::size_t i = 0; i < walks.size(); ++i) {
    const EpisodeView one = read.walk(i), wanted = view_of(walks[i]);
    EXPECT_EQ(one.episode, 10 + i);
    EXPECT_TRUE(std::ranges::equal(one.pictures, wanted.pictures)) << i;
    EXPECT_TRUE(std::ranges::equal(one.depth, wanted.depth)) << i;
    EXPECT_TRUE(std::ranges::equal(one.previous, wanted.previous)) << i;
    EXPECT_TRUE(std::ranges::equal(one.teacher, wanted.teacher)) << i;
  }
  EXPECT_THAT([&] { EpisodeFile(file, width + 1); },
              ThrowsMessage<InvalidInput>(HasSubstr("pictures")));
  features::write_safetensors(file, {}, {});
  EXPECT_THAT([&] { EpisodeFile(file, width); },
              ThrowsMessage<InvalidInput>(HasSubstr("not a file of recorded walks")));
}

TEST(Batches, APassHasEachWalkOnceLongerOnesFirst) {
  std::vector<std::size_t> lengths;
  for (std::size_t i = 0; i < 103; ++i) lengths.push_back(1 + i * 37 % 50);
  std::multiset<std::size_t> all;
  const auto batches = pass_over(lengths, 5, 1, 2);
  for (const auto& batch : batches) {
    EXPECT_LE(batch.size(), 5U);
    EXPECT_TRUE(std::ranges::is_sorted(batch, std::ranges::greater{},
                                       [&](std::size_t walk) { return lengths[walk]; }));
    all.insert(batch.begin(), batch.end());
  }
  EXPECT_EQ(batches.size(), 21U);
  EXPECT_EQ(all.size(), 103U);
  EXPECT_EQ(std::set<std::size_t>(all.begin(), all.end()).size(), 103U);
  EXPECT_EQ(batches, pass_over(lengths, 5, 1, 2));
  EXPECT_NE(batches, pass_over(lengths, 5, 1, 3));
}

TEST(Batches, UpdatesGoThroughSetsAndPasses) {
  models::Seq2SeqCeConfig config;
  config.sets = 3;
  config.set_walks = 5;
  config.epochs = 2;
  // 5, 10 and 15 walks in batches of 4: 2, 3 and 4 updates a pass.
  EXPECT_EQ(models::updates_of(config, 4), 2U * (2 + 3 + 4));
  std::vector<std::array<std::size_t, 3>> found;
  for (std::uint64_t update = 0; update < 18; ++update) {
    const UpdatePlace place = place_of(config, 4, update);
    found.push_back({place.sets, place.epoch, place.batch});
    EXPECT_EQ(place.first(), update == 0 || update == 4 || update == 10) << update;
  }
  std::vector<std::array<std::size_t, 3>> expected;
  for (std::size_t sets = 1; sets <= 3; ++sets) {
    for (std::size_t epoch = 0; epoch < 2; ++epoch) {
      for (std::size_t batch = 0; batch < sets + 1; ++batch)
        expected.push_back({sets, epoch, batch});
    }
  }
  EXPECT_EQ(found, expected);
}

/// Ends a training as a signal would.
struct Stopped {};
TrainingListener stop_at(std::uint64_t iteration) {
  TrainingListener listener;
  listener.iteration = [iteration](const TrainingProgress& progress) {
    if (progress.iteration == iteration) throw Stopped();
  };
  return listener;
}

TEST_F(SeesTwoBuildings, GoesOnToTheBitAfterBeingStoppedAnywhere) {
  const models::TrainConfig config = small_config();
  const TrainingData all = data(config);
  EXPECT_TRUE(train(config, all, folder("whole")));
  EXPECT_FALSE(train(config, all, folder("whole"))) << "it is complete";
  // Within the first set, at its end (6 updates of 5 walks in twos), within the last.
  for (const std::uint64_t stop : {3U, 6U, 7U, 13U}) {
    EXPECT_THROW(train(config, all, folder("stopped"), {}, stop_at(stop)), Stopped) << stop;
  }
  EXPECT_TRUE(train(config, all, folder("stopped")));
  EXPECT_EQ(tests::weights_of(folder("stopped")), tests::weights_of(folder("whole")));
  // While a set is gathered.
  TrainingListener listener;
  listener.gathering = [](const GatheringProgress& progress) {
    if (progress.set == 2) throw Stopped();
  };
  EXPECT_THROW(train(config, all, folder("gathering"), {}, listener), Stopped);
  EXPECT_TRUE(train(config, all, folder("gathering")));
  EXPECT_EQ(tests::weights_of(folder("gathering")), tests::weights_of(folder("whole")));
}

TEST_F(SeesTwoBuildings, LostWalksAreNamed) {
  const models::TrainConfig config = small_config();
  const TrainingData all = data(config);
  EXPECT_THROW(train(config, all, folder("model"), {}, stop_at(6)), Stopped);
  fs::remove(models::ModelFiles{folder("model")}.walks(1, "bare"));
  EXPECT_THAT([&] { train(config, all, folder("model")); },
              ThrowsMessage<FileError>(HasSubstr("bare.safetensors: there are no such walks")));
}

TEST_F(SeesTwoBuildings, OtherOptionsAndOtherEyesAreRefused) {
  models::TrainConfig config = small_config();
  EXPECT_TRUE(train(config, data(config), folder("model")));
  config.seq2seq_ce.hidden = 24;
  EXPECT_THAT([&] { train(config, data(config), folder("model")); },
              ThrowsMessage<ArgumentError>(HasSubstr("hidden: 32, not 24")));
  ContinuousSight other = world_->sight();
  other.encoder.seed = 2;
  EXPECT_THAT(
      [&] { load_continuous_agent(folder("model"), other); },
      ThrowsMessage<ArgumentError>(HasSubstr("not the encoder that the agent was trained")));
  EXPECT_THAT([&] { load_continuous_agent(folder("model"), {}); },
              ThrowsMessage<ArgumentError>(HasSubstr("scene_of: empty")));
  EXPECT_THAT([&] { load_trained_agent(folder("model")); },
              ThrowsMessage<ArgumentError>(HasSubstr("a continuous agent, not one of the graph")));
  // An encoder of another width in the model's place.
  std::string text = read_file(models::ModelFiles{folder("model")}.config());
  const std::string features =
      fmt::format("\"features\": {}", SightEncoder(world_->sight()).info().dimensions);
  ASSERT_NE(text.find(features), std::string::npos);
  text.replace(text.find(features), features.size(), "\"features\": 64");
  write_file_atomically(models::ModelFiles{folder("model")}.config(), text);
  EXPECT_THAT([&] { load_continuous_agent(folder("model"), world_->sight()); },
              ThrowsMessage<ArgumentError>(HasSubstr("made for 64 numbers a picture")));
}

TEST_F(SeesTwoBuildings, AModelOfTheGraphDoesNotWalkFreely) {
  models::ModelConfig config;
  config.training.network.vocabulary = 4;
  fs::create_directories(folder("graph"));
  write_file_atomically(models::ModelFiles{folder("graph")}.config(), to_json(config));
  write_file_atomically(models::ModelFiles{folder("graph")}.weights(), "");
  EXPECT_THAT([&] { load_continuous_agent(folder("graph"), world_->sight()); },
              ThrowsMessage<ArgumentError>(HasSubstr("an agent seq2seq, of the graph")));
  EXPECT_THAT([&] { train(config.training, data(small_config()), folder("other")); },
              ThrowsMessage<ArgumentError>(HasSubstr("the agent seq2seq is for graphs")));
}

TEST_F(SeesTwoBuildings, MoreSetsGoOnWithAFinishedTraining) {
  models::TrainConfig config = small_config();
  EXPECT_TRUE(train(config, data(config), folder("two")));
  config.seq2seq_ce.sets = 1;
  EXPECT_TRUE(train(config, data(config), folder("one")));
  config.seq2seq_ce.sets = 2;
  EXPECT_TRUE(train(config, data(config), folder("one")));
  EXPECT_EQ(tests::weights_of(folder("one")), tests::weights_of(folder("two")));
}

// Ten seconds of learning five walks by heart: what is seen tells buildings apart, words tell two
// ways around the pillar apart.
TEST_F(SeesTwoBuildings, LearnsAFewWalksByHeart) {
  models::TrainConfig config = small_config();
  config.seq2seq_ce.sets = 3;
  config.seq2seq_ce.epochs = 40;
  config.seq2seq_ce.hidden = 48;
  config.batch_size = 5;
  config.adam.learning_rate = 5e-3;
  EXPECT_TRUE(train(config, data(config), folder("model")));
  const auto agent = load_continuous_agent(folder("model"), world_->sight());
  EXPECT_EQ(agent->name(), "seq2seq-ce");
  const tasks::ContinuousEpisodes all = episodes();
  const auto walks = walk(*agent, all);
  const tasks::ExpertWalks experts = agents::record_experts(all, world_->buildings);
  double arrived = 0;
  for (std::size_t i = 0; i < walks.size(); ++i) {
    const auto score =
        agents::score_continuous_walk(walks[i], all.episodes[i], *world_->buildings, experts);
    arrived += score.success;
    EXPECT_GT(score.ndtw, .5) << i << ": along the way that the words say";
  }
  EXPECT_GE(arrived, 4);
  // One at a time they are walked as all at once, but for rounding in the products.
  const auto alone = walk(*agent, all, 1);
  std::size_t same = 0;
  for (std::size_t i = 0; i < walks.size(); ++i) same += alone[i].actions == walks[i].actions;
  EXPECT_GE(same, 4U);
}

TEST_F(SeesTwoBuildings, BlindOnesNeedNoEyes) {
  models::TrainConfig config = small_config();
  config.network.inputs = models::parse_inputs("language");
  EXPECT_TRUE(train(config, data(config, {}), folder("model")));
  const auto agent = load_continuous_agent(folder("model"), {});
  EXPECT_EQ(walk(*agent, episodes()).size(), 5U);
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural::continuous
