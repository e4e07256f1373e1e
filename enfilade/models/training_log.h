/// \file  The log of a training run: log.jsonl of a model directory, and TensorBoard's events.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade::models {

/// The training loss over some consecutive iterations.
struct TrainRecord {
  std::uint64_t iteration = 0;  ///< the last of them
  double loss = 0;              ///< mean of the iterations; each summed over steps, by max_steps
  double seconds = 0;           ///< spent on all of them, evaluation left out
  double time = 0;              ///< when it was logged, seconds since 1970; set by the log
};

/// The result of an evaluation during training. Rates are shares, 0 to 1; lengths are in metres.
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
  double time = 0;  ///< as TrainRecord's
};

/// The result of an evaluation of a speaker during training: how well it describes the paths of a
/// split.
struct SpeakerRecord {
  std::uint64_t iteration = 0;
  std::string split;
  std::size_t instructions = 0;  ///< predicted
  double loss = 0;               ///< cross-entropy a word, natural logarithm, without dropout
  double perplexity = 0;         ///< e to the power of `loss`
  double accuracy = 0;           ///< share of words of which the likeliest is right, 0 to 1
  double bleu = 0;               ///< BLEU-4 of greedy instructions, one per path, 0 to 1
  double time = 0;               ///< as TrainRecord's
};

/// The content of a log.
struct TrainingHistory {
  std::vector<TrainRecord> training;          ///< by rising iteration
  std::vector<EvaluationRecord> evaluations;  ///< by rising iteration of each split
  std::vector<SpeakerRecord> speaker;         ///< likewise; of speakers

  double seconds() const noexcept;  ///< of all training records together
};

/// Reads a log.jsonl. Each line is a JSON object whose "type" is "train", "evaluation", "speaker"
/// or another one, which is ignored, as are further fields. So is an incomplete last line, of a
/// running or killed training. After a resume from a checkpoint, iterations come again: the later
/// ones count.
///
/// Required are "iteration" and "loss" of training, and "iteration", "split", "nav_error" and
/// "success_rate" of an evaluation. An evaluation's other numbers are NaN if missing, as are those
/// of "speaker" except "iteration" and "split".
/// \throws FileError; InvalidInput naming the line
TrainingHistory load_training_log(const std::filesystem::path& file);
/// The same for a text; `file` is its name in messages.
TrainingHistory parse_training_log(std::string_view lines, const std::string& file);

/// Writes both logs of a model directory. If the process is killed, at most the line being written
/// is lost. One thread.
class TrainingLog {
 public:
  /// Continues the log.jsonl at `log` and writes the events beside it anew. Lines beyond
  /// `iteration`, whose iterations will be done again, and an incomplete last line are cut off.
  /// \throws FileError; InvalidInput as load_training_log()
  TrainingLog(const std::filesystem::path& log, std::uint64_t iteration);
  ~TrainingLog();
  TrainingLog(const TrainingLog&) = delete;
  TrainingLog& operator=(const TrainingLog&) = delete;

  /// \param config the model's config.json \param iteration done before \throws FileError
  void start(const std::string& config, std::uint64_t iteration);
  void add(TrainRecord record);       ///< \throws FileError
  void add(EvaluationRecord record);  ///< \throws FileError
  void add(SpeakerRecord record);     ///< \throws FileError

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::models
