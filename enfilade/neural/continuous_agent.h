/// \file  The continuous agent (`seq2seq-ce`): its data, and a trained one.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/agents/continuous_agent.h"
#include "enfilade/agents/continuous_setup.h"
#include "enfilade/continuous/eyes.h"
#include "enfilade/models/model_directory.h"
#include "enfilade/models/train_config.h"
#include "enfilade/neural/encoder.h"
#include "enfilade/neural/training_data.h"

namespace enfilade::neural {

/// How an agent sees.
struct ContinuousSight {
  enfilade::continuous::SceneSource scene_of;  ///< called from one thread
  EncoderConfig encoder;  ///< turns pictures into features; its weights stay as they are
  int threads = 0;        ///< of drawing, 0: all cores; changes no result
};

/// Training and validation data of the agent.
struct ContinuousData {
  agents::ContinuousSetup setup;
  tasks::ContinuousEpisodes training;                 ///< of all splits trained on
  std::vector<tasks::ContinuousEpisodes> validation;  ///< one a split
  std::shared_ptr<const enfilade::continuous::Buildings> buildings;
  ContinuousSight sight;  ///< does not count if the agent is not to see
};

/// Progress of collecting a continuous agent's rollouts, the next training data.
struct GatheringProgress {
  std::size_t set = 1, sets = 1;     ///< which, of how many
  std::size_t walks = 0, total = 0;  ///< of this set
};

/// Reads the episodes that `config` names, and describes them and the encoder in the fingerprint.
/// \param data the folder of a data set
/// \throws ArgumentError for a benchmark other than r2r-ce, whose four actions the agent has
/// \throws ArgumentError for hidden goals, for fewer buildings than the config requires, or if the
/// agent uses vision and there is no scene_of
/// \throws FileError naming the verb that makes the missing file; errors of the files; as
/// make_encoder()
TrainingData load_continuous_data(const std::filesystem::path& data,
                                  const agents::ContinuousSetup& setup,
                                  const models::TrainConfig& config, const ContinuousSight& sight);

/// A trained agent, from its model directory. Chooses the most likely action. It stops at the
/// latest after the number of actions in training (TrainConfig::max_steps).
class TrainedContinuousAgent : public agents::ContinuousAgent {
 public:
  virtual const models::ModelConfig& config() const noexcept = 0;
  virtual std::uint64_t iteration() const noexcept = 0;  ///< of the weights
};
/// \param sight its encoder is the one of training, with the weights in the model directory. Its
/// own weights count only for a model that was trained with random ones
/// \throws FileError for a missing file; InvalidInput for damaged files, or weights that do not fit
/// \throws ArgumentError for a model of a graph agent, or if the model uses vision and there is no
/// scene_of
/// \throws ArgumentError for an encoder that is not the one of training, naming the difference
std::unique_ptr<TrainedContinuousAgent> load_continuous_agent(const std::filesystem::path& folder,
                                                              const ContinuousSight& sight);

}  // namespace enfilade::neural
