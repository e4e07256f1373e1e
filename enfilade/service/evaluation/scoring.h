/// \file  Results files of a phase, checked and scored by the scorer of its benchmark. Any thread.
#pragma once
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/service/site.h"

namespace enfilade::service::evaluation {

/// What scoring a file gives.
struct Judgement {
  std::string score;   ///< as Submission::score
  double primary = 0;  ///< the mean of the phase's primary metric: shares from 0 to 1; may be NaN
  std::string ends;    ///< trajectory_ends()
};

/// Checks a whole file. \param episodes of the phase \returns its warnings
/// \throws InvalidInput with its faults (up to 1000); of walks in continuous space also for steps
/// that are longer than the benchmark's, and for more actions than it allows: the public scorers
/// look at neither, and would take a jump to the goal for a walk
std::vector<Diagnostic> check_results(const Phase& phase, const SecretEpisodes& episodes,
                                      const std::string& results);
/// \throws as check_results()
Judgement score_results(const Phase& phase, const SecretEpisodes& episodes,
                        const std::string& results);

}  // namespace enfilade::service::evaluation
