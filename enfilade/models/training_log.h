/// \file  What training says of itself in its folder: log.jsonl and TensorBoard's events.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace enfilade::models {

/// What an evaluation during training found. Rates are shares, 0 to 1; lengths metres.
struct EvaluationRecord {
  std::uint64_t iteration = 0;
  std::string split;
  std::size_t episodes = 0;
  double loss = 0;  ///< dropout on, the training's feedback; summed over steps, by max_steps
  double trajectory_length = 0;
  double nav_error = 0;
  double success_rate = 0;
  double oracle_success_rate = 0;
  double spl = 0;
};

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
  ~TrainingLog();
  TrainingLog(const TrainingLog&) = delete;
  TrainingLog& operator=(const TrainingLog&) = delete;

  /// \param config the model's config.json \param iteration done before
  void start(const std::string& config, std::uint64_t iteration);
  void add(const TrainRecord& record);
  void add(const EvaluationRecord& record);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::models
