/// \file  What training wrote down as it went: log.jsonl of a model directory.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade::report {

/// After one iteration, or the mean of some.
struct TrainingPoint {
  double iteration = 0;
  double loss = 0;  ///< as logged: the sum over steps / 20
};

/// Of a whole split.
struct EvaluationPoint {
  double iteration = 0;
  std::string split;
  double loss = 0;       ///< as logged; NaN if the line has none
  double nav_error = 0;  ///< metres
  double success = 0;    ///< [0, 1]
};

struct TrainingLog {
  std::vector<TrainingPoint> training;       ///< by rising iteration
  std::vector<EvaluationPoint> evaluations;  ///< likewise
  double seconds = 0;                        ///< of all iterations together
};

/// Reads JSON lines of {"type": "start" | "train" | "evaluation" | ..., ...}; other types and
/// fields are ignored, so is a last line that has no end (training is writing it, or was killed).
/// Where training went on from a checkpoint, iterations come again: the later ones count. \throws
/// FileError; InvalidInput naming the line
TrainingLog load_training_log(const std::filesystem::path& file);
TrainingLog parse_training_log(std::string_view lines, const std::string& file);

/// At most `most` points: each the mean of as many that follow each other.
std::vector<TrainingPoint> thinned(const std::vector<TrainingPoint>& points, std::size_t most);

}  // namespace enfilade::report
