/// \file  Submissions that equal an earlier one in all but a few episodes. Goals can be read from
/// scores by small changes, so organisers are notified. Teams are not, and nothing is refused:
/// tuning a method may give such files too.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "enfilade/tasks/continuous_results.h"
#include "enfilade/tasks/results.h"

namespace enfilade::service::store {
class Database;
}

namespace enfilade::service::evaluation {

/// The end and the answer (an object, a turning point, a point in the panorama) of each trajectory,
/// as hashes of 4 bytes, in order. Success, navigation error and grounding depend on nothing else
/// of it. Detours, turns and another order of the file change nothing. The bytes of two files on
/// the same graphs can be compared.
std::string trajectory_ends(const std::vector<tasks::Trajectory>& trajectories);
/// The same for continuous trajectories: to a quarter of a metre, a step's length, and whether the
/// agent stopped there.
std::string trajectory_ends(const std::vector<tasks::ContinuousResult>& walks);

/// How many episodes end elsewhere; none if the two are of different numbers of episodes.
std::optional<std::size_t> count_differing(std::string_view ends, std::string_view other);

/// How many episodes of a near-copy may end elsewhere: 5 or 2 %, whichever is more, but no more
/// than a quarter.
std::size_t most_differing(std::size_t episodes) noexcept;

/// An earlier submission, of whatever team, and how many episodes end elsewhere.
struct NearCopy {
  std::int64_t of = 0;
  std::int64_t differing = 0;
  auto columns() { return std::tie(of, differing); }
};

/// The nearest of the submissions before `id` in these phases, the first of several; no value if
/// all differ in more than most_differing() episodes.
/// \param phases with the same episodes
std::optional<NearCopy> find_near_copy(store::Database& db, const std::vector<std::string>& phases,
                                       std::int64_t id, std::string_view ends);

}  // namespace enfilade::service::evaluation
