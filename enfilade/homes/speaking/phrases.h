/// \file  Sentences out of patterns with choices. Internal.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/rng.h"

namespace enfilade::homes::speaking {

/// Words that go where a pattern says $name.
using Slots = std::vector<std::pair<std::string_view, std::string>>;

/// "[walk|go] past the $thing|pass the $thing": one of the choices, and one in each pair of
/// brackets, which may nest; slots are filled in. \pre brackets match, slots are there
std::string expand(std::string_view pattern, const Slots& slots, Rng& rng);

/// "a large sofa", "an armchair": the article for a name.
std::string with_article(const std::string& name);

/// First letter large, a full stop at the end.
std::string sentence(std::string text);

/// How clauses are joined.
enum class Links : std::uint8_t {
  kAny,    ///< in one of several ways
  kShort,  ///< in the fewest words
};
/// "a", "a and b", "a, b and c", "a, then b"; clauses with an "and" or a comma of their own are
/// kept apart by a comma or "then". \pre not empty
std::string join_clauses(const std::vector<std::string>& clauses, Links links, Rng& rng);

}  // namespace enfilade::homes::speaking
