#include "tests/support/untrained.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/core/errors.h"
#include "enfilade/neural/trained_agent.h"
#include "tests/support/small_training.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::tests {
namespace EN_UNIT {

using models::AgentKind;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

models::ModelConfig config_of(AgentKind agent) {
  models::ModelConfig config;
  config.training = SmallTraining::config(agent);
  config.training.network.vocabulary = 4;
  config.training.network.features = SmallTraining::kDimensions;
  return config;
}

TEST(UntrainedTest, ModelsAreLoadedAsTrainedOnes) {
  const TemporaryFolder folder("untrained");
  for (const AgentKind kind : {AgentKind::kPanoramic, AgentKind::kDuet}) {
    const auto model = folder.path() / to_string(kind);
    write_untrained(config_of(kind), model);
    tasks::Vocabulary::of({"<PAD>", "<UNK>", "<EOS>", "go"})
        .save(models::ModelFiles{model}.vocabulary());
    const auto agent = neural::load_trained_agent(model);
    EXPECT_EQ(agent->name(), to_string(kind));
    EXPECT_EQ(agent->iteration(), 0U);
  }
}

TEST(UntrainedTest, OtherAgentsAreRefused) {
  const TemporaryFolder folder("untrained");
  for (const AgentKind kind : {AgentKind::kSeq2Seq, AgentKind::kSpeaker}) {
    EXPECT_THAT([&] { write_untrained(config_of(kind), folder.path() / "model"); },
                ThrowsMessage<ArgumentError>(HasSubstr("panoramic or duet")));
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::tests
