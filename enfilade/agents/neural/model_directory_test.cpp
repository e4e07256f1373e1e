#include "enfilade/agents/neural/model_directory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::agents::neural {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
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
  FeatureInfo features;
  features.encoder = "resnet152";
  features.preprocessing = "caffe";
  features.dimensions = 7;
  config.data.features = features;
  return config;
}

class ModelDirectoryTest : public ::testing::Test {
 protected:
  ModelDirectoryTest() {
    r2r::Vocabulary::build(std::vector<std::string>{"go left"}, 1).save(files_.vocabulary());
    write_file_atomically(files_.config(), to_json(config_));
    write_state(files_.weights(), network_.weights(), 40);
  }

  // Writes the config with one place changed.
  void edit_config(const std::string& from, const std::string& to) {
    std::string text = to_json(config_);
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    write_file_atomically(files_.config(), text.replace(at, from.size(), to));
  }

  void flip_last_byte(const fs::path& file) const {
    std::string bytes = read_file(file);
    bytes.back() = static_cast<char>(bytes.back() ^ 1);
    write_file_atomically(file, bytes);
  }

  tests::TemporaryFolder folder_{"model"};
  ModelFiles files_{folder_.path()};
  ModelConfig config_ = small_config();
  Network network_{config_.training.network, 1};
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

TEST_F(ModelDirectoryTest, ModelIsReadBackWithItsWeights) {
  Model model = load_model(folder_.path());
  EXPECT_EQ(model.iteration, 40U);
  EXPECT_EQ(model.vocabulary.size(), 5U);
  write_state(folder_.path() / "again.safetensors", model.network.weights(), 40);
  EXPECT_EQ(read_file(folder_.path() / "again.safetensors"), read_file(files_.weights()));
}

TEST_F(ModelDirectoryTest, NamesTheFileThatIsMissing) {
  fs::remove(files_.weights());
  EXPECT_THAT(
      [&] { load_model(folder_.path()); },
      ThrowsMessage<FileError>(HasSubstr("no weights.safetensors in it, so it is no model")));
}

TEST_F(ModelDirectoryTest, NamesEveryFaultOfAConfig) {
  edit_config("\"teacher\"", "\"nobody\"");
  EXPECT_THAT([&] { load_model(folder_.path()); },
              ThrowsMessage<InvalidInput>(
                  HasSubstr("$.training.feedback: feedback \"nobody\": student or teacher")));
  edit_config("\"hidden\": 6", "\"hidden\": -6");
  EXPECT_THAT([&] { load_model(folder_.path()); },
              ThrowsMessage<InvalidInput>(HasSubstr("$.network.hidden: -6, not 0 or more")));
  edit_config("\"enfilade-model\"", "\"another\"");
  EXPECT_THAT([&] { load_model(folder_.path()); },
              ThrowsMessage<InvalidInput>(HasSubstr("$.format: not \"enfilade-model\"")));
}

TEST_F(ModelDirectoryTest, AVocabularyOfAnotherSizeIsAnError) {
  r2r::Vocabulary::build(std::vector<std::string>{"go left now"}, 1).save(files_.vocabulary());
  EXPECT_THAT(
      [&] { load_model(folder_.path()); },
      ThrowsMessage<InvalidInput>(AllOf(HasSubstr("vocabulary.txt"),
                                        HasSubstr("6 words, but the network was made for 5"))));
}

TEST_F(ModelDirectoryTest, WeightsOfAnotherNetworkAreAnError) {
  edit_config("\"hidden\": 6", "\"hidden\": 16");
  EXPECT_THAT([&] { load_model(folder_.path()); }, ::testing::Throws<InvalidInput>());
}

TEST_F(ModelDirectoryTest, ABrokenByteOfWeightsIsFound) {
  flip_last_byte(files_.weights());
  EXPECT_THAT([&] { load_model(folder_.path()); },
              ThrowsMessage<InvalidInput>(HasSubstr("its bytes are not those that were written")));
}

TEST_F(ModelDirectoryTest, FeaturesOfAnotherSizeAreAnError) {
  EXPECT_THAT([&] { usable_features(config_, nullptr); },
              ThrowsMessage<ArgumentError>(HasSubstr("needs features")));
  FeatureInfo info;
  info.dimensions = 3;
  const fs::path file = folder_.path() / "f.safetensors";
  FeatureWriter writer = FeatureWriter::create(file, info, {{"one", "v0"}});
  writer.write(0, std::vector<float>(3 * 36));
  writer.finish();
  const FeatureSet set = FeatureSet::open(file);
  EXPECT_THAT([&] { usable_features(config_, &set); },
              ThrowsMessage<ArgumentError>(
                  HasSubstr("features of 3 numbers a view; the network was made for 7")));
  config_.training.network.inputs.vision = false;
  EXPECT_EQ(usable_features(config_, &set), nullptr);
}

TEST_F(ModelDirectoryTest, CheckpointKeepsTheOneBefore) {
  write_checkpoint(files_, network_, 100);
  EXPECT_FALSE(fs::exists(files_.previous_checkpoint()));
  write_checkpoint(files_, network_, 200);
  EXPECT_EQ(open_state(files_.checkpoint()).iteration, 200U);
  EXPECT_EQ(open_state(files_.previous_checkpoint()).iteration, 100U);
  EXPECT_EQ(open_state(files_.weights()).iteration, 200U);
}

TEST_F(ModelDirectoryTest, StatesOfOthersAreRefused) {
  const auto state = network_.weights();
  write_safetensors(files_.weights(), state.arrays);
  EXPECT_THAT([&] { open_state(files_.weights()); },
              ThrowsMessage<InvalidInput>(HasSubstr("not written by Enfilade's training")));
  write_safetensors(files_.weights(), state.arrays, {{"iteration", "ten"}, {"hash", ""}});
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

}  // namespace
}  // namespace enfilade::agents::neural
