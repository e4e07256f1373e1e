/// \file  Scores as clients see them. Only means over a whole split leave the server: the
/// navigation error of one episode would tell where its goal is.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "enfilade/service/evaluation/submissions.h"

namespace enfilade::service::evaluation {

/// How much of a submission's scores a client may see.
enum class Visibility : std::uint8_t {
  kHidden,
  /// To 0.01 m and 0.1 %, as papers round: the exact means of two files that differ in one episode
  /// would tell how far that episode's goal is.
  kRounded,
  kExact,
};
/// \param phase null: one that is no longer there  \param role of who asks; none for strangers
Visibility visibility_of(const Phase* phase, std::optional<accounts::Role> role);

/// With "means" if it is scored and they are not hidden.
nlohmann::ordered_json submission_json(const Submission& submission, Visibility visibility);

/// Rows by falling SPL, older ones first where equal. \param all every submission; else the best of
/// each team  \pre visibility is not kHidden
nlohmann::ordered_json leaderboard_rows(const std::vector<Submission>& scored,
                                        Visibility visibility, bool all);
/// The same rows as a sheet, with the ends of the intervals.
std::string leaderboard_csv(const nlohmann::ordered_json& rows);

}  // namespace enfilade::service::evaluation
