/// \file  Results files of a phase, checked and scored by the scorer of its benchmark. Any thread.
#pragma once
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/service/site.h"

namespace enfilade::service::evaluation {

/// The result of scoring a file.
struct Judgement {
  std::string score;   ///< as Submission::score
  double primary = 0;  ///< the mean of the phase's primary metric: shares from 0 to 1; may be NaN
  std::string ends;    ///< trajectory_ends()
};

/// Checks a whole file. \param episodes of the phase \returns its warnings
/// \throws InvalidInput with its faults (up to 1000). For continuous trajectories also for steps
/// that are longer, or more actions, than the benchmark allows. The public scorers check neither,
/// and would accept a jump to the goal.
std::vector<Diagnostic> check_results(const Phase& phase, const SecretEpisodes& episodes,
                                      const std::string& results);
/// \throws as check_results()
Judgement score_results(const Phase& phase, const SecretEpisodes& episodes,
                        const std::string& results);

}  // namespace enfilade::service::evaluation
