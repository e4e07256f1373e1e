#include "enfilade/neural/seq2seq/evaluation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::neural::seq2seq {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class ModelTest : public ::testing::Test {
 protected:
  ModelTest() {
    config_.training.network = {5, 8, 4, 6, 3, 7, 0.25, {true, true}};
    tasks::Vocabulary::build(std::vector<std::string>{"go left"}, 1).save(files_.vocabulary());
    write_file_atomically(files_.config(), to_json(config_));
    models::write_state(files_.weights(), Network(config_.training.network, 1).weights().arrays,
                        40);
  }

  tests::TemporaryFolder folder_{"model"};
  models::ModelFiles files_{folder_.path()};
  models::ModelConfig config_;
};

TEST_F(ModelTest, IsReadBackWithItsWeights) {
  Model model = load_model(folder_.path());
  EXPECT_EQ(model.iteration, 40U);
  EXPECT_EQ(model.vocabulary.size(), 5U);
  models::write_state(folder_.path() / "again.safetensors", model.network->weights().arrays, 40);
  EXPECT_EQ(read_file(folder_.path() / "again.safetensors"), read_file(files_.weights()));
}

TEST_F(ModelTest, NamesTheFileThatIsMissing) {
  std::filesystem::remove(files_.weights());
  EXPECT_THAT(
      [&] { load_model(folder_.path()); },
      ThrowsMessage<FileError>(HasSubstr("no weights.safetensors in it, so it is no model")));
}

TEST_F(ModelTest, AVocabularyOfAnotherSizeIsAnError) {
  tasks::Vocabulary::build(std::vector<std::string>{"go left now"}, 1).save(files_.vocabulary());
  EXPECT_THAT(
      [&] { load_model(folder_.path()); },
      ThrowsMessage<InvalidInput>(AllOf(HasSubstr("vocabulary.txt"),
                                        HasSubstr("6 words, but the network was made for 5"))));
}

TEST_F(ModelTest, WeightsOfAnotherNetworkAreAnError) {
  config_.training.network.hidden = 16;
  write_file_atomically(files_.config(), to_json(config_));
  EXPECT_THAT([&] { load_model(folder_.path()); }, ::testing::Throws<InvalidInput>());
}

TEST_F(ModelTest, ABrokenByteOfWeightsIsFound) {
  std::string bytes = read_file(files_.weights());
  bytes.back() = static_cast<char>(bytes.back() ^ 1);
  write_file_atomically(files_.weights(), bytes);
  EXPECT_THAT([&] { load_model(folder_.path()); },
              ThrowsMessage<InvalidInput>(HasSubstr("its bytes are not those that were written")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural::seq2seq
