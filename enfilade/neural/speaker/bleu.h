/// \file  BLEU: how much of generated instructions is in those of people.
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace enfilade::neural::speaker {

/// A generated text, and those that people wrote for the same.
struct Generated {
  std::vector<std::string> words;                    ///< of the text
  std::vector<std::vector<std::string>> references;  ///< at least one
};

/// Of a whole corpus: the geometric mean of the shares of generated n-grams, 1 to 4, that a
/// reference has (as often as it has them), times the brevity penalty; 0 to 1. As the code that
/// EnvDrop scored its speaker with, a reference's length is that of the shortest, and nothing is
/// smoothed: 0 where some order has no match. reference: Papineni, Roukos, Ward, Zhu 2002,
/// section 2.
double bleu_4(std::span<const Generated> corpus);

}  // namespace enfilade::neural::speaker
