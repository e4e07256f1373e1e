/// \file  Interface of an agent in training: its updates, its rollouts, its state.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "enfilade/features/tensor_file.h"
#include "enfilade/models/model_directory.h"
#include "enfilade/models/training_log.h"
#include "enfilade/neural/core/weights.h"
#include "enfilade/neural/ranks.h"
#include "enfilade/neural/training_data.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::neural::core {

/// Result of one update.
struct Update {
  double loss = 0;          ///< as the log has it
  double data_seconds = 0;  ///< in environment, features and instructions
};

/// How an agent that walks does in a split.
struct ValidationRollout {
  double loss = 0;
  std::vector<tasks::Trajectory> trajectories;  ///< greedy, one per episode
};
/// Validation record of an agent on graphs, of a speaker or of a continuous agent; the last two
/// without the iteration.
using Evaluated = std::variant<ValidationRollout, models::SpeakerRecord, models::EvaluationRecord>;

/// One kind of agent in training. train() owns directory, log, checkpoints and the order of work, a
/// learner all else. All random numbers are named by the config's seed and the iteration, so that
/// the state is only parameters and moments. One thread at a time.
class Learner {
 public:
  virtual ~Learner() = default;
  /// Encodes instructions and looks up features. Called once, before the functions below, with the
  /// weights in place.
  /// \param ranks the processes that train together; outlive *this
  /// \throws ArgumentError if they cannot share the parts of a batch
  virtual void prepare(const TrainingData& data, Ranks& ranks) = 0;
  /// One update of the weights. \param iteration updates before it
  virtual Update update(std::uint64_t iteration) = 0;
  /// Validates the agent on split `split` after `iteration` iterations. Rank 0 writes the results
  /// below `files`. No effect on the weights.
  /// \pre split < TrainingData::validation.size()
  virtual Evaluated evaluate(std::size_t split, std::uint64_t iteration,
                             const models::ModelFiles& files) = 0;

  /// Takes the weights of another model, ahead of the first update. \throws ArgumentError for an
  /// agent that cannot; InvalidInput as load_training_state()
  virtual void begin_with(const features::TensorFile& weights);

  virtual State weights() const = 0;
  virtual State training_state() const = 0;
  /// \throws InvalidInput naming every missing, surplus and wrong-shaped array
  virtual void load_training_state(const features::TensorFile& file) = 0;
};

}  // namespace enfilade::neural::core
