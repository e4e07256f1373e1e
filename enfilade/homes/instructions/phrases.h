/// \file  Builds sentences from patterns with random choices. Internal.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/rng.h"

namespace enfilade::homes::instructions {

/// Names and the words that replace `$name` in a pattern.
using Slots = std::vector<std::pair<std::string_view, std::string>>;

/// Fills in a pattern such as "[walk|3*go] past the $thing|pass the $thing". Draws one of the
/// choices, one in each pair of brackets (which may nest), and replaces the slots. A choice after
/// `3*` has the weight 3 (1 to 9).
/// \pre brackets match; all slots are given
std::string expand(std::string_view pattern, const Slots& slots, Rng& rng);

/// The name with its article: "a large sofa", "an armchair".
std::string with_article(const std::string& name);

/// The text with a capital first letter and a full stop.
std::string sentence(std::string text);

/// How clauses are joined.
enum class ClauseLinks : std::uint8_t {
  kAny,    ///< in one of several ways
  kShort,  ///< in the fewest words
};
/// Joins clauses: "a", "a and b", "a, b and c", "a, then b". Clauses that contain "and" or a comma
/// themselves are separated by a comma or "then". \pre not empty
std::string join_clauses(const std::vector<std::string>& clauses, ClauseLinks links, Rng& rng);

}  // namespace enfilade::homes::instructions
