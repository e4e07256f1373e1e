/// \file  Rules that walk a session without a model: what a stand-in answers by, and baselines.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <string_view>

#include "enfilade/arena/session.h"

namespace enfilade::arena {

/// By name.
enum class Rule : std::uint8_t {
  kFirst,   ///< always to the first place, and never stops
  kRandom,  ///< as the agent "random" of the same seed, step by step
  kOracle,  ///< the shortest way to the goal; of REVERIE it names the object
  kStop,    ///< stops at once
};
constexpr std::array<std::string_view, 4> names_of(Rule /*enum*/) {
  return {"first", "random", "oracle", "stop"};
}
/// \throws LookupError listing the names
Rule rule_named(std::string_view name);

/// Follows a rule through one session.
class Follower {
 public:
  virtual ~Follower() = default;
  /// The next call. \pre the session has not ended, and did all that was said before
  virtual Call next() = 0;
};

/// \param session outlives it \param seed of kRandom
/// \throws ArgumentError for kOracle where the goal is hidden
std::unique_ptr<Follower> follow(Rule rule, const GraphWorld& world, const GraphSession& session,
                                 std::uint64_t seed = 1);

}  // namespace enfilade::arena
