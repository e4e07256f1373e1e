/// \file  Training an agent: data in, model directory out.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "enfilade/dataset/dataset.h"
#include "enfilade/models/train_config.h"
#include "enfilade/models/training_log.h"
#include "enfilade/neural/device.h"
#include "enfilade/neural/training_data.h"

namespace enfilade::neural {

struct GatheringProgress;  // continuous_agent.h

/// Reads what `config` names. \throws ArgumentError if the agent is to see and `features` is none;
/// errors of the files
TrainingData load_training_data(const dataset::Dataset& dataset, const models::TrainConfig& config,
                                const std::optional<std::filesystem::path>& features);

/// Progress of training.
struct TrainingProgress {
  std::uint64_t iteration = 0;  ///< done
  std::uint64_t iterations = 0;
  double loss = 0;          ///< of this iteration: summed over steps, by max_steps
  double seconds_left = 0;  ///< at the pace so far, evaluations included
  double data_share = 0;    ///< of training's time: environment, features, instructions
};

/// Callbacks of train(), called from its thread. An exception ends the training and leaves the
/// model directory valid.
struct TrainingListener {
  std::function<void(std::uint64_t iteration)> resumed;  ///< after a checkpoint was loaded
  std::function<void(const TrainingProgress&)> iteration;
  std::function<void(const models::EvaluationRecord&)> evaluation;
  std::function<void(const models::SpeakerRecord&)> speaker;  ///< instead, for speakers
  std::function<void(const GatheringProgress&)> gathering;    ///< of continuous agents
};

/// Trains to config.iterations, from the checkpoint in `directory` if there is one, and leaves a
/// model directory there. The same config and data give the same weights, on the CPU to the bit, on
/// a card except for the order of some sums. That also holds if training was killed and continued
/// any number of times. Returns false if there was nothing to do.
///
/// If several processes train together (Computing::ranks, with TrainConfig::parts), all call this
/// with the same arguments and share one `directory`. Only rank 0 writes and calls `listener`. With
/// the same parts and threads per process, any number of processes gives the same bits, also if
/// another number continues a training. A process that ends or differs ends all: call this within
/// tell_failures().
///
/// \param from the directory of another model of duet with the same sizes: training begins with its
/// weights and words. Needed again to continue
/// \throws ArgumentError for an impossible config or computing, or a difference (named) from the
/// model in `directory`, its data, or the sizes of `from`
/// \throws FileError if another process trains there, or a file cannot be written: then the last
/// checkpoint is whole
/// \throws InvalidInput for a broken checkpoint, naming the one before it
/// \throws Error for a loss that is not finite; LostRank
bool train(const models::TrainConfig& config, const TrainingData& data,
           const std::filesystem::path& directory, const Computing& computing = {},
           const TrainingListener& listener = {},
           const std::optional<std::filesystem::path>& from = {});

}  // namespace enfilade::neural
