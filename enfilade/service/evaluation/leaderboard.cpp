#include "enfilade/service/evaluation/leaderboard.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "enfilade/service/detail/names.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/evaluation/shown_metrics.h"

namespace enfilade::service::evaluation {
namespace {

using nlohmann::ordered_json;

std::string primary_of(const View& view) {
  const Primary primary = view.phase == nullptr ? Primary::kSpl : view.phase->primary;
  return std::string(detail::name_of(primary));
}

/// A stored mean; null is an infinite one.
double mean_of(const ordered_json& score, const std::string& metric) {
  const ordered_json& mean = score.at("means").at(metric).at("mean");
  return mean.is_number() ? mean.get<double>() : HUGE_VAL;
}

/// The means that the visibility allows. \param view of kBestRows or kAll
ordered_json means_json(const ordered_json& score, const View& view) {
  ordered_json means;
  for (const ShownMetric& metric : kShownMetrics) {
    if (view.visibility == Visibility::kAll) {
      means[metric.name] = score.at("means").at(metric.name);
      continue;
    }
    const double mean = mean_of(score, metric.name);
    means[metric.name]["mean"] = metric.quantity == Quantity::kWalked
                                     ? mean
                                     : grid_of(*view.phase, metric.quantity).round(mean);
  }
  return means;
}

/// What "withheld" says of a scored submission without means.
const char* why_withheld(const View& view) {
  switch (view.visibility) {
    case Visibility::kImprovements:
      return "no-improvement";
    case Visibility::kBestRows:
      return "not-best";
    default:
      return view.phase != nullptr && view.phase->scores == Scores::kAfterEnd ? "until-end"
                                                                              : "hidden";
  }
}

/// A submission with the two values that it is compared by.
struct Ranked {
  const Submission* submission = nullptr;
  double exact = 0;  ///< chooses a team's best
  double shown = 0;  ///< orders the rows
};

/// None if the submission has no place on the leaderboard.
std::optional<Ranked> ranked(const Submission& submission, const View& view) {
  if (view.visibility == Visibility::kImprovements) {
    if (!submission.shown) return std::nullopt;
    return Ranked{&submission, *submission.shown, *submission.shown};
  }
  const double exact = mean_of(ordered_json::parse(submission.score), primary_of(view));
  if (view.visibility == Visibility::kAll) return Ranked{&submission, exact, exact};
  return Ranked{&submission, exact, grid_of(*view.phase, Quantity::kOfGoals).round(exact)};
}

std::vector<Ranked> rank(const std::vector<Submission>& scored, const View& view) {
  std::vector<Ranked> list;
  for (const Submission& submission : scored) {
    if (view.visibility != Visibility::kAll && !submission.approved) continue;
    if (const auto one = ranked(submission, view)) list.push_back(*one);
  }
  return list;
}

/// Keeps each team's best.
void keep_best(std::vector<Ranked>& list) {
  std::ranges::stable_sort(list, std::ranges::greater{}, &Ranked::exact);
  std::set<std::int64_t> seen;
  std::erase_if(list,
                [&seen](const Ranked& one) { return !seen.insert(one.submission->team).second; });
}

/// By what is shown, then by age: where two shown values are equal, an order by the exact ones
/// would tell which is larger.
void sort_rows(std::vector<Ranked>& list) {
  std::ranges::sort(list, [](const Ranked& a, const Ranked& b) {
    return a.shown != b.shown ? a.shown > b.shown : a.submission->id < b.submission->id;
  });
}

/// A number of a mean as the sheet has it; empty where it is not shown.
std::string cell(const ordered_json& means, const char* metric, const char* part) {
  const auto found = means.find(metric);
  return found == means.end() || !found->contains(part) ? "" : found->at(part).dump();
}

}  // namespace

View view_of(const Phase* phase, std::optional<accounts::Role> role, bool is_final) {
  if (role == accounts::Role::kOrganiser) return {Visibility::kAll, phase};
  if (phase == nullptr || phase->scores == Scores::kHidden) return {Visibility::kNothing, phase};
  if (!phase->goals_secret()) return {Visibility::kAll, phase};
  if (is_final) return {Visibility::kBestRows, phase};
  const bool ladder = phase->scores == Scores::kLadder;
  return {ladder ? Visibility::kImprovements : Visibility::kNothing, phase};
}

std::vector<Submission> best_submissions(const std::vector<Submission>& scored, const View& view) {
  std::vector<Ranked> list = rank(scored, view);
  keep_best(list);
  sort_rows(list);
  std::vector<Submission> best;
  for (const Ranked& one : list) best.push_back(*one.submission);
  return best;
}

ordered_json submission_json(const Submission& submission, const View& view, bool stands_for_team) {
  const bool nothing = view.visibility == Visibility::kNothing;
  const bool waits =
      submission.state == SubmissionState::kQueued || submission.state == SubmissionState::kScored;
  ordered_json one{{"id", submission.id},
                   {"team", submission.team_name},
                   {"phase", submission.phase},
                   {"method", submission.method},
                   {"state", nothing && waits ? "received" : detail::name_of(submission.state)},
                   {"created", detail::iso_time(submission.created)}};
  if (!submission.links.paper.empty()) one["paper"] = submission.links.paper;
  if (!submission.links.code.empty()) one["code"] = submission.links.code;
  if (view.visibility == Visibility::kImprovements && submission.shown) {
    one["means"][primary_of(view)]["mean"] = *submission.shown;
  } else if (!submission.score.empty() &&
             (view.visibility == Visibility::kAll ||
              (view.visibility == Visibility::kBestRows && stands_for_team))) {
    one["means"] = means_json(ordered_json::parse(submission.score), view);
  } else if ((nothing && waits) || submission.state == SubmissionState::kScored) {
    one["withheld"] = why_withheld(view);
  }
  // Looked for where goals are secret only, and there organisers alone see everything.
  if (view.visibility == Visibility::kAll && submission.near_copy.of != 0) {
    one["near_copy"] = {{"of", submission.near_copy.of},
                        {"differing", submission.near_copy.differing}};
  }
  return one;
}

ordered_json leaderboard_rows(const std::vector<Submission>& scored, const View& view, bool all) {
  std::vector<Ranked> list = rank(scored, view);
  if (!all || view.visibility != Visibility::kAll) keep_best(list);
  sort_rows(list);
  auto rows = ordered_json::array();
  for (const Ranked& one : list) rows.push_back(submission_json(*one.submission, view, true));
  return rows;
}

std::string leaderboard_csv(const ordered_json& rows) {
  std::string out = "team,method,created";
  for (const ShownMetric& metric : kShownMetrics) {
    out += fmt::format(",{0},{0}_low,{0}_high", metric.name);
  }
  out += "\r\n";
  for (const ordered_json& row : rows) {
    out += fmt::format("{},{},{}", detail::sheet_text(row["team"]),
                       detail::sheet_text(row["method"]), row["created"].get<std::string>());
    for (const ShownMetric& metric : kShownMetrics) {
      for (const char* part : {"mean", "low", "high"}) {
        out += "," + cell(row["means"], metric.name, part);
      }
    }
    out += "\r\n";
  }
  return out;
}

}  // namespace enfilade::service::evaluation
