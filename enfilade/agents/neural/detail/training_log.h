/// \file  What training says of itself in its folder: log.jsonl and TensorBoard's events.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/agents/neural/detail/append_file.h"
#include "enfilade/agents/neural/detail/event_file.h"
#include "enfilade/agents/neural/trainer.h"

namespace enfilade::agents::neural {

/// A stretch of iterations.
struct TrainRecord {
  std::uint64_t iteration = 0;  ///< the last of the stretch
  double loss = 0;              ///< mean of the stretch
  double seconds = 0;           ///< of all of them, evaluation left out
};

/// Both logs of a model directory. Killing the process loses at most the line being written. One
/// thread.
class TrainingLog {
 public:
  /// Goes on with a log.jsonl and the events beside it. Of what is there, lines beyond `iteration`,
  /// which will come again, and a half-written last line are cut off, and the events are written
  /// anew from the rest. \throws FileError; InvalidInput for a log that is none
  TrainingLog(const std::filesystem::path& log, std::uint64_t iteration);

  /// \param config the model's config.json \param iteration done before
  void start(const std::string& config, std::uint64_t iteration);
  void add(const TrainRecord& record);
  void add(const EvaluationRecord& record);

  /// What an old log says, with the seconds since 1970 of each line.
  struct Kept {
    std::vector<std::pair<double, TrainRecord>> train;
    std::vector<std::pair<double, EvaluationRecord>> evaluation;
  };

 private:
  TrainingLog(const std::filesystem::path& log, const Kept& kept);
  void show(const TrainRecord& record, double time);
  void show(const EvaluationRecord& record, double time);

  AppendFile lines_;
  EventFile events_;
};

}  // namespace enfilade::agents::neural
