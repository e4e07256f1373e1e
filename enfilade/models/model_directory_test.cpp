#include "enfilade/models/model_directory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::models {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;

ModelConfig small_config() {
  ModelConfig config;
  config.training.network = {5, 8, 4, 6, 3, 7, 0.25, {true, true}};
  config.training.feedback = Feedback::kTeacher;
  config.training.seed = 3;
  config.training.splits = {"train", "val_seen"};
  config.training.after_end = AfterEnd::kStays;
  config.training.forward = ForwardTo::kIntended;
  config.data.annotations["train"] = "0123456789abcdef";
  config.data.graphs["one"] = "fedcba9876543210";
  features::FeatureInfo features;
  features.encoder = "resnet152";
  features.preprocessing = "caffe";
  features.dimensions = 7;
  config.data.features = features;
  return config;
}

class ModelDirectoryTest : public ::testing::Test {
 protected:
  ModelDirectoryTest() {
    tasks::Vocabulary::build(std::vector<std::string>{"go left"}, 1).save(files_.vocabulary());
    write_file_atomically(files_.config(), to_json(config_));
  }

  // Writes the config with one place changed.
  void edit_config(const std::string& from, const std::string& to) {
    std::string text = to_json(config_);
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    write_file_atomically(files_.config(), text.replace(at, from.size(), to));
  }

  tests::TemporaryFolder folder_{"model"};
  ModelFiles files_{folder_.path()};
  ModelConfig config_ = small_config();
  std::vector<float> values_{1, 2, 3};
  std::vector<features::NamedArray> arrays_{
      {"bias", features::DType::kFloat32, {3}, std::as_bytes(std::span(values_))}};
};

TEST_F(ModelDirectoryTest, ConfigIsReadBackEqual) {
  const ModelConfig read = load_model_config(files_.config());
  EXPECT_EQ(to_json(read), to_json(config_));
  EXPECT_EQ(read.training.network.hidden, 6U);
  EXPECT_EQ(read.training.feedback, Feedback::kTeacher);
  EXPECT_EQ(read.training.forward, ForwardTo::kIntended);
  EXPECT_THAT(read.training.splits, ElementsAre("train", "val_seen"));
  EXPECT_EQ(read.data.features->encoder, "resnet152");
}

TEST_F(ModelDirectoryTest, NamesEveryFaultOfAConfig) {
  edit_config("\"teacher\"", "\"nobody\"");
  EXPECT_THAT([&] { load_model_config(files_.config()); },
              ThrowsMessage<InvalidInput>(
                  HasSubstr("$.training.feedback: feedback \"nobody\": student or teacher")));
  edit_config("\"hidden\": 6", "\"hidden\": -6");
  EXPECT_THAT([&] { load_model_config(files_.config()); },
              ThrowsMessage<InvalidInput>(HasSubstr("$.network.hidden: -6, not 0 or more")));
  edit_config("\"enfilade-model\"", "\"another\"");
  EXPECT_THAT([&] { load_model_config(files_.config()); },
              ThrowsMessage<InvalidInput>(HasSubstr("$.format: not \"enfilade-model\"")));
}

TEST_F(ModelDirectoryTest, ABrokenByteOfAStateIsFound) {
  write_state(files_.weights(), arrays_, 40);
  std::string bytes = read_file(files_.weights());
  bytes.back() = static_cast<char>(bytes.back() ^ 1);
  write_file_atomically(files_.weights(), bytes);
  EXPECT_THAT([&] { open_state(files_.weights()); },
              ThrowsMessage<InvalidInput>(HasSubstr("its bytes are not those that were written")));
}

TEST_F(ModelDirectoryTest, AgentsReadWordsOrPieces) {
  TrainConfig& training = config_.training;
  training = recipe(AgentKind::kDuet);
  training.network.vocabulary = 5;
  const auto again = [&] {
    write_file_atomically(files_.config(), to_json(config_));
    return load_model_config(files_.config()).training;
  };
  EXPECT_EQ(load_instruction_words(files_, again()).size(), 7U) << "<BOS> and <MASK> beside";
  EXPECT_EQ(duet_sizes(training).vocabulary, 7);
  edit_config("  \"text\": \"words\",\n", "");
  EXPECT_EQ(load_model_config(files_.config()).training.text, TextKind::kWords) << "as before";

  training.text = TextKind::kWordPieces;
  training.letters = Letters::kAsWritten;
  EXPECT_EQ(duet_sizes(training).vocabulary, 5);
  write_file_atomically(files_.text(training.text), "[PAD]\n[UNK]\n[CLS]\n[SEP]\nGo\n");
  EXPECT_THAT(load_instruction_words(files_, again()).encode("Go go", 9), ElementsAre(2, 4, 1, 3));
  training.network.vocabulary = 6;
  EXPECT_THAT([&] { load_instruction_words(files_, again()); },
              ThrowsMessage<InvalidInput>(
                  HasSubstr("pieces.txt: 5 pieces, but the network was made for 6")));
  edit_config("\"cased\"", "\"big\"");
  EXPECT_THAT([&] { load_model_config(files_.config()); },
              ThrowsMessage<InvalidInput>(HasSubstr("$.network.letters: letters \"big\": cased")));
  training.text = TextKind::kSentencePieces;
  EXPECT_THAT([&] { load_instruction_words(files_, again()); },
              ThrowsMessage<FileError>(HasSubstr("pieces.model")));
}

TEST_F(ModelDirectoryTest, ASpeakersConfigIsReadBack) {
  TrainConfig& training = config_.training;
  training = recipe(AgentKind::kSpeaker);
  training.network.vocabulary = 5;
  training.network.features = 7;
  training.speaker.hidden = 10;
  training.speaker.bidirectional = false;
  training.speaker.feature_dropout = 0.25;
  write_file_atomically(files_.config(), to_json(config_));
  const TrainConfig read = load_model_config(files_.config()).training;
  EXPECT_EQ(read.agent, AgentKind::kSpeaker);
  SpeakerConfig sizes = training.speaker;
  sizes.vocabulary = 6;
  sizes.image = 7;
  EXPECT_EQ(speaker_sizes(read), sizes) << "<BOS> beside";
  EXPECT_EQ(read.optimizer, Optimizer::kAdam);
  EXPECT_THAT(differences(read, training), ElementsAre());
  training.feedback = Feedback::kSample;
  EXPECT_THAT([&] { validate(training); },
              ThrowsMessage<ArgumentError>(HasSubstr("is trained with teacher alone")));
  training = recipe(AgentKind::kSpeaker);
  training.network.inputs = parse_inputs("vision");
  EXPECT_THAT([&] { validate(training); },
              ThrowsMessage<ArgumentError>(HasSubstr("inputs vision: the speaker learns")));
  training = recipe(AgentKind::kSpeaker);
  training.text = TextKind::kWordPieces;
  EXPECT_THAT([&] { validate(training); },
              ThrowsMessage<ArgumentError>(HasSubstr("text word-pieces: the speaker writes")));
}

TEST_F(ModelDirectoryTest, TheStageAndTheFirstWeightsAreReadBack) {
  const TrainConfig pretraining = recipe(AgentKind::kDuet, Recipe::kPublished, Stage::kPretrain);
  config_.training = pretraining;
  config_.training.initial_weights = "00ff";
  write_file_atomically(files_.config(), to_json(config_));
  const TrainConfig there = load_model_config(files_.config()).training;
  EXPECT_EQ(there.stage, Stage::kPretrain);
  EXPECT_EQ(there.initial_weights, "00ff");
  EXPECT_EQ(there.warm_up, 10'000U);
  EXPECT_THAT(differences(there, pretraining), ElementsAre("initial_weights: \"00ff\", not none"));
  edit_config("  \"stage\": \"pretrain\",\n", "");
  EXPECT_EQ(load_model_config(files_.config()).training.stage, Stage::kFineTune) << "as before";
  edit_config("\"pretrain\"", "\"sleep\"");
  EXPECT_THAT(
      [&] { load_model_config(files_.config()); },
      ThrowsMessage<InvalidInput>(HasSubstr("$.training.stage: stage \"sleep\": fine-tune")));
}

TEST_F(ModelDirectoryTest, WhereAWalkEndsIsNoPartOfTheWeights) {
  config_.training = recipe(AgentKind::kDuet);
  const TrainConfig best = config_.training;
  config_.training.final_stop = StopRule::kOwn;
  write_file_atomically(files_.config(), to_json(config_));
  const TrainConfig own = load_model_config(files_.config()).training;
  EXPECT_EQ(own.final_stop, StopRule::kOwn);
  EXPECT_TRUE(duet_sizes(own).stays_where_it_stops);
  EXPECT_FALSE(duet_sizes(best).stays_where_it_stops);
  EXPECT_THAT(differences(own, best), IsEmpty());
  edit_config("  \"final_stop\": \"own\",\n", "");
  EXPECT_EQ(load_model_config(files_.config()).training.final_stop, StopRule::kBest) << "as before";
  edit_config("\"own\"", "\"here\"");
  EXPECT_THAT([&] { load_model_config(files_.config()); },
              ThrowsMessage<InvalidInput>(HasSubstr("$.training.final_stop: final stop \"here\"")));
}

TEST_F(ModelDirectoryTest, WeightsFitNetworksOfTheSameSizes) {
  TrainConfig one = recipe(AgentKind::kDuet), other = one;
  other.stage = Stage::kPretrain;
  other.duet.dropout = 0.2;
  other.network.max_words = 80;
  other.seed = 7;
  EXPECT_TRUE(size_differences(one, other).empty());
  other.duet.hidden = 384;
  other.network.vocabulary += 1;
  EXPECT_EQ(size_differences(one, other).size(), 2U);
  EXPECT_THAT(size_differences(recipe(AgentKind::kPanoramic), one),
              ElementsAre("agent: panoramic, not duet"));
  one.agent = AgentKind::kPanoramic;
  one.stage = Stage::kPretrain;
  EXPECT_THAT([&] { validate(one); },
              ThrowsMessage<ArgumentError>(HasSubstr("stage pretrain: the agent panoramic")));
}

TEST_F(ModelDirectoryTest, FeaturesOfAnotherSizeAreAnError) {
  EXPECT_THAT([&] { usable_features(config_, nullptr); },
              ThrowsMessage<ArgumentError>(HasSubstr("needs features")));
  features::FeatureInfo info;
  info.dimensions = 3;
  const fs::path file = folder_.path() / "f.safetensors";
  features::FeatureWriter writer = features::FeatureWriter::create(file, info, {{"one", "v0"}});
  writer.write(0, std::vector<float>(3 * 36));
  writer.finish();
  const features::FeatureSet set = features::FeatureSet::open(file);
  EXPECT_THAT([&] { usable_features(config_, &set); },
              ThrowsMessage<ArgumentError>(
                  HasSubstr("features of 3 numbers a view; the network was made for 7")));
  config_.training.network.inputs.vision = false;
  EXPECT_EQ(usable_features(config_, &set), nullptr);
}

TEST_F(ModelDirectoryTest, CheckpointKeepsTheOneBefore) {
  write_checkpoint(files_, arrays_, arrays_, 100);
  EXPECT_FALSE(fs::exists(files_.previous_checkpoint()));
  write_checkpoint(files_, arrays_, arrays_, 200);
  EXPECT_EQ(open_state(files_.checkpoint()).iteration, 200U);
  EXPECT_EQ(open_state(files_.previous_checkpoint()).iteration, 100U);
  EXPECT_EQ(open_state(files_.weights()).iteration, 200U);
}

TEST_F(ModelDirectoryTest, StatesOfOthersAreRefused) {
  features::write_safetensors(files_.weights(), arrays_);
  EXPECT_THAT([&] { open_state(files_.weights()); },
              ThrowsMessage<InvalidInput>(HasSubstr("not written by Enfilade's training")));
  features::write_safetensors(files_.weights(), arrays_, {{"iteration", "ten"}, {"hash", ""}});
  EXPECT_THAT([&] { open_state(files_.weights()); },
              ThrowsMessage<InvalidInput>(HasSubstr("iteration \"ten\", not a whole number")));
}

TEST(DataFingerprint, SaysWhatDiffersOfWhatBothName) {
  const DataFingerprint trained = small_config().data;
  EXPECT_THAT(differences(trained, trained, "m"), IsEmpty());
  EXPECT_THAT(differences(trained, {}, "m"), IsEmpty());
  DataFingerprint now = trained;
  now.annotations["train"] = "0";
  now.graphs["one"] = "1";
  now.graphs["two"] = "2";  // which training never saw
  now.features->encoder = "home";
  now.features->camera.width = 320;
  const auto found = differences(trained, now, "model/config.json");
  ASSERT_EQ(found.size(), 4U);
  EXPECT_EQ(to_string(found[0]),
            "warning: model/config.json: $.data.annotations.train: trained on 0123456789abcdef, "
            "here it is 0 [other-annotations]");
  EXPECT_EQ(found[1].where, "$.data.graphs.one");
  EXPECT_EQ(found[2].message, "trained on resnet152, here it is home");
  EXPECT_EQ(found[3].message, "trained on 640x480, 60 degrees, here it is 320x480, 60 degrees");
}

TEST(TrainConfig, DifferencesLeaveOutWhatWeightsDoNotDependOn) {
  TrainConfig a, b;
  b.iterations = 7;
  b.validation.clear();
  b.evaluate_every = 0;
  b.checkpoint_every = 1;
  EXPECT_THAT(differences(a, b), IsEmpty());
  b.network.hidden = 256;
  b.feedback = Feedback::kTeacher;
  b.adam.learning_rate = 0.5;
  EXPECT_THAT(differences(a, b),
              ElementsAre("hidden: 512, not 256", "feedback: \"student\", not \"teacher\"",
                          "learning_rate: 0.0001, not 0.5"));
}

TEST(TrainConfig, ValidateNamesTheField) {
  struct Case {
    std::function<void(TrainConfig&)> damage;
    const char* says;
  };
  for (const Case& one : std::vector<Case>{
           {[](TrainConfig& c) { c.network.hidden = 0; }, "hidden: 0"},
           {[](TrainConfig& c) { c.network.dropout = 1; }, "dropout: 1"},
           {[](TrainConfig& c) { c.adam.learning_rate = -1; }, "learning_rate: -1"},
           {[](TrainConfig& c) { c.batch_size = 0; }, "batch_size: 0"},
           {[](TrainConfig& c) { c.max_steps = 0; }, "max_steps: 0"},
           {[](TrainConfig& c) { c.splits.clear(); }, "splits: 0"},
           {[](TrainConfig& c) { c.feedback = Feedback::kArgmax; }, "feedback argmax"}}) {
    TrainConfig config;
    EXPECT_NO_THROW(validate(config));
    one.damage(config);
    EXPECT_THAT([&] { validate(config); }, ThrowsMessage<ArgumentError>(HasSubstr(one.says)));
  }
}

TEST(TrainConfig, InputsAreReadByTheirNames) {
  for (const char* name : {"language+vision", "language", "vision", "none"}) {
    EXPECT_EQ(to_string(parse_inputs(name)), name);
  }
  EXPECT_FALSE(parse_inputs("language").vision);
  EXPECT_THAT([] { parse_inputs("smell"); },
              ThrowsMessage<ArgumentError>(HasSubstr("\"smell\": one of none, language, vision")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::models
