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

/// BLEU-4 of a whole corpus, 0 to 1. It is the geometric mean of the shares of generated n-grams, 1
/// to 4, that a reference has (clipped counts), times the brevity penalty. As in EnvDrop's scoring
/// of its speaker, a reference's length is that of the shortest. Nothing is smoothed: 0 if some
/// order has no match. Source: Papineni, Roukos, Ward, Zhu 2002, section 2.
double bleu_4(std::span<const Generated> corpus);

}  // namespace enfilade::neural::speaker
