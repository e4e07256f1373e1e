/// \file  Scores for clients. Only means over a whole split leave the server: the navigation error
/// of one episode would give its goal away. With secret goals, leakage.h bounds the shown means.
/// Nothing else may depend on goals: not the order of rows, not the time of a response's change.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/service/evaluation/submissions.h"

namespace enfilade::service::evaluation {

/// How much of a phase's scores a client may see.
enum class Visibility : std::uint8_t {
  kNothing,       ///< not even that a submission is scored: how long that took depends on goals
  kImprovements,  ///< scores shown on a ladder
  kBestRows,      ///< each team's best submission, its means rounded, without intervals
  kAll,
};

/// A phase as one client sees it now.
struct View {
  Visibility visibility = Visibility::kNothing;
  /// The phase's rules; null: a phase that is no longer there, of which nothing is seen but by
  /// organisers.
  const Phase* phase = nullptr;
};
/// \param role of the client; no value for strangers  \param is_final Submissions::is_final()
View view_of(const Phase* phase, std::optional<accounts::Role> role, bool is_final);

/// The submission that represents each team, in the order of the leaderboard. It is the best by the
/// primary metric, or with a ladder the last improvement; the first of several. Rows are sorted by
/// the shown values, older ones first if equal. With secret goals, only approved teams.
/// \param scored of one phase, oldest first
/// \pre visibility is not kNothing
std::vector<Submission> best_submissions(const std::vector<Submission>& scored, const View& view);

/// With "means" as far as the client may see them, shares from 0 to 1 in any scorer's units.
/// Otherwise "withheld" gives the reason: "until-end", "no-improvement", "not-best", "hidden", or
/// "other-scorer" if the phase had another task or scorer when it was scored.
/// \param stands_for_team whether it is among best_submissions(); used for kBestRows
nlohmann::ordered_json submission_json(const Submission& submission, const View& view,
                                       bool stands_for_team);

/// \param all every submission instead of each team's best; only where all scores are seen
nlohmann::ordered_json leaderboard_rows(const std::vector<Submission>& scored, const View& view,
                                        bool all);
/// The columns that the rows' means have, in their order: [{"name", "short", "title", "unit": "m"
/// or "share", "better"?: "higher" or "lower"}].
nlohmann::ordered_json columns_json(const Phase& phase);
/// The same rows as a sheet, with the ends of the intervals where they are seen.
std::string leaderboard_csv(const nlohmann::ordered_json& rows, const Phase& phase);

}  // namespace enfilade::service::evaluation
