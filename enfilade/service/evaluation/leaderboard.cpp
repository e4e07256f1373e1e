#include "enfilade/service/evaluation/leaderboard.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "enfilade/service/detail/names.h"
#include "enfilade/service/detail/texts.h"

namespace enfilade::service::evaluation {
namespace {

using nlohmann::ordered_json;

/// The table's columns in their order, names of r2r::metric_fields().
constexpr std::array<const char*, 8> kColumns{"trajectory_length", "nav_error", "success",
                                              "oracle_success",    "spl",       "ndtw_collapsed",
                                              "sdtw_collapsed",    "cls"};

void round_mean(std::string_view column, ordered_json& mean) {
  const double parts = column == "trajectory_length" || column == "nav_error" ? 100 : 1000;
  for (ordered_json& value : mean) {  // the mean and its interval; null if infinite
    if (value.is_number()) value = std::round(value.get<double>() * parts) / parts;
  }
}

ordered_json means_json(const Submission& submission, Visibility visibility) {
  const ordered_json score = ordered_json::parse(submission.score);
  ordered_json means;
  for (const char* column : kColumns) {
    means[column] = score.at("means").at(column);
    if (visibility == Visibility::kRounded) round_mean(column, means[column]);
  }
  return means;
}

double spl_of(const ordered_json& row) { return row["means"]["spl"]["mean"].get<double>(); }

}  // namespace

Visibility visibility_of(const Phase* phase, std::optional<accounts::Role> role) {
  if (role == accounts::Role::kOrganiser) return Visibility::kExact;
  if (phase == nullptr || phase->scores == Scores::kHidden) return Visibility::kHidden;
  return phase->goals_secret() ? Visibility::kRounded : Visibility::kExact;
}

ordered_json submission_json(const Submission& submission, Visibility visibility) {
  ordered_json one{{"id", submission.id},
                   {"team", submission.team_name},
                   {"phase", submission.phase},
                   {"method", submission.method},
                   {"state", detail::name_of(submission.state)},
                   {"created", detail::iso_time(submission.created)}};
  if (!submission.score.empty() && visibility != Visibility::kHidden) {
    one["means"] = means_json(submission, visibility);
  }
  return one;
}

ordered_json leaderboard_rows(const std::vector<Submission>& scored, Visibility visibility,
                              bool all) {
  std::vector<ordered_json> rows;
  for (const Submission& submission : scored) {
    rows.push_back(submission_json(submission, visibility));
  }
  std::ranges::stable_sort(rows, std::ranges::greater{}, spl_of);
  std::set<std::string> seen;
  auto kept = ordered_json::array();
  for (ordered_json& row : rows) {
    if (seen.insert(row["team"].get<std::string>()).second || all) kept.push_back(std::move(row));
  }
  return kept;
}

std::string leaderboard_csv(const ordered_json& rows) {
  std::string out = "team,method,created";
  for (const char* column : kColumns) out += fmt::format(",{0},{0}_low,{0}_high", column);
  out += "\r\n";
  for (const ordered_json& row : rows) {
    out += fmt::format("{},{},{}", detail::sheet_text(row["team"]),
                       detail::sheet_text(row["method"]), row["created"].get<std::string>());
    for (const char* column : kColumns) {
      for (const char* part : {"mean", "low", "high"}) {
        out += "," + row["means"][column][part].dump();
      }
    }
    out += "\r\n";
  }
  return out;
}

}  // namespace enfilade::service::evaluation
