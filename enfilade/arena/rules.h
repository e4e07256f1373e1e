/// \file  Rules that step through a session without a model: answers of a mock server, and
/// baselines.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <string_view>

#include "enfilade/arena/world.h"

namespace enfilade::arena {

/// By name.
enum class Rule : std::uint8_t {
  kFirst,   ///< always to the first place, and never stops; in continuous space forward
  kRandom,  ///< as the agent "random" of the same seed, step by step
  kOracle,  ///< the shortest way to the goal; of REVERIE it names the object, of R2R-Back the turn
  kStop,    ///< stops at once
};
constexpr std::array<std::string_view, 4> names_of(Rule /*enum*/) {
  return {"first", "random", "oracle", "stop"};
}
/// \throws LookupError listing the names
Rule rule_named(std::string_view name);

/// Follows a rule through one session; World::follow() makes one, which the session outlives.
class Follower {
 public:
  virtual ~Follower() = default;
  /// The next call. \pre the session has not ended, and did all that was said before
  virtual Call next() = 0;
};

}  // namespace enfilade::arena
