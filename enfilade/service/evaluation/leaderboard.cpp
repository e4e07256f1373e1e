#include "enfilade/service/evaluation/submissions.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "enfilade/core/enum_names.h"
#include "enfilade/core/errors.h"
#include "enfilade/service/detail/column_json.h"
#include "enfilade/service/detail/json_list.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/evaluation/leakage.h"
#include "enfilade/tasks/published.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::service::evaluation {
namespace {

using nlohmann::ordered_json;

/// A stored score; none of a benchmark or scorer that is no longer there.
std::optional<tasks::ScoreTable> stored_score(const Submission& submission) {
  try {
    return tasks::from_json(submission.score);
  } catch (const LookupError&) {
    return std::nullopt;
  }
}

/// Whether a stored score was made as the phase says now: organisers may have changed its file.
bool fits(const std::optional<tasks::ScoreTable>& score, const Phase& phase) {
  return score && score->benchmark == phase.benchmark && score->scorer == phase.scorer;
}

/// A mean in metres, or as a share from 0 to 1; the worst where it is no finite number.
double mean_of(const tasks::ScoreTable& score, const tasks::Measure& measure) {
  const double mean = score.mean(measure.name).mean;
  if (std::isfinite(mean)) return mean / measure.whole;
  return measure.better == tasks::Better::kHigher ? -HUGE_VAL : HUGE_VAL;
}

/// A mean and its interval in metres, or as shares from 0 to 1, whatever the scorer prints.
ordered_json exact_json(const tasks::MeanInterval& mean, const tasks::Measure& measure) {
  return {{"mean", mean.mean / measure.whole},
          {"low", mean.low / measure.whole},
          {"high", mean.high / measure.whole}};
}

/// The means that the visibility allows. \param view of kBestRows or kAll
ordered_json means_json(const tasks::ScoreTable& score, const PhaseView& view) {
  if (view.visibility == Visibility::kAll) return exact_means_json(score);
  ordered_json means = ordered_json::object();
  for (const tasks::Measure& measure : score.scorer->columns) {
    const double mean = mean_of(score, measure);
    means[measure.name]["mean"] =
        measure.tells_goals ? grid_of(*view.phase, measure).round(mean) : mean;
  }
  return means;
}

/// What "withheld" says of a scored submission without means.
const char* why_withheld(const PhaseView& view) {
  if (view.visibility == Visibility::kImprovements) return "no-improvement";
  if (view.visibility == Visibility::kBestRows) return "not-best";
  return view.phase != nullptr && view.phase->scores == Scores::kAfterEnd ? "until-end" : "hidden";
}

/// A submission with the two values that it is compared by.
struct Ranked {
  const Submission* submission = nullptr;
  double exact = 0;  ///< chooses a team's best
  double shown = 0;  ///< orders the rows
};

/// None if the submission has no place on the leaderboard.
std::optional<Ranked> ranked(const Submission& submission, const PhaseView& view) {
  if (view.visibility == Visibility::kImprovements) {
    if (!submission.shown) return std::nullopt;
    return Ranked{&submission, *submission.shown, *submission.shown};
  }
  const auto score = score_of(submission, *view.phase);
  if (!score) return std::nullopt;
  const tasks::Measure& primary = view.phase->primary_measure();
  const double exact = mean_of(*score, primary);
  if (view.visibility == Visibility::kAll) return Ranked{&submission, exact, exact};
  return Ranked{&submission, exact, grid_of(*view.phase, primary).round(exact)};
}

/// A number of a mean as the sheet has it; empty where it is not shown.
std::string cell(const ordered_json& means, const char* measure, const char* part) {
  const auto found = means.find(measure);
  return found == means.end() || !found->contains(part) ? "" : found->at(part).dump();
}

}  // namespace

ordered_json exact_means_json(const tasks::ScoreTable& score) {
  ordered_json means = ordered_json::object();
  for (const tasks::Measure& measure : score.scorer->columns) {
    means[measure.name] = exact_json(score.mean(measure.name), measure);
  }
  return means;
}

std::optional<tasks::ScoreTable> score_of(const Submission& submission, const Phase& phase) {
  if (submission.score.empty()) return std::nullopt;
  auto score = stored_score(submission);
  return fits(score, phase) ? std::move(score) : std::nullopt;
}

PhaseView view_of(const Phase* phase, std::optional<accounts::ClientRole> role, bool is_final) {
  if (role == accounts::ClientRole::kOrganiser) return {Visibility::kAll, phase};
  if (phase == nullptr || phase->scores == Scores::kHidden) return {Visibility::kNothing, phase};
  if (!phase->goals_secret()) return {Visibility::kAll, phase};
  if (is_final) return {Visibility::kBestRows, phase};
  const bool ladder = phase->scores == Scores::kLadder;
  return {ladder ? Visibility::kImprovements : Visibility::kNothing, phase};
}

std::vector<Submission> best_submissions(const std::vector<Submission>& scored,
                                         const PhaseView& view, bool all) {
  std::vector<Ranked> list;
  for (const Submission& submission : scored) {
    if (view.visibility != Visibility::kAll && !submission.approved) continue;
    if (const auto one = ranked(submission, view)) list.push_back(*one);
  }
  if (!all || view.visibility != Visibility::kAll) {
    std::ranges::stable_sort(list, std::ranges::greater{}, &Ranked::exact);
    std::set<std::int64_t> seen;
    std::erase_if(list,
                  [&seen](const Ranked& one) { return !seen.insert(one.submission->team).second; });
  }
  // By what is shown, then by age: where two shown values are equal, an order by the exact ones
  // would tell which is larger.
  std::ranges::sort(list, [](const Ranked& a, const Ranked& b) {
    return a.shown != b.shown ? a.shown > b.shown : a.submission->id < b.submission->id;
  });
  std::vector<Submission> best;
  for (const Ranked& one : list) best.push_back(*one.submission);
  return best;
}

ordered_json submission_json(const Submission& submission, const PhaseView& view,
                             bool stands_for_team) {
  const bool nothing = view.visibility == Visibility::kNothing;
  const bool waits =
      submission.state == SubmissionState::kQueued || submission.state == SubmissionState::kScored;
  ordered_json one{{"id", submission.id},
                   {"team", submission.team_name},
                   {"phase", submission.phase},
                   {"method", submission.method},
                   {"state", nothing && waits ? "received" : enum_name(submission.state)},
                   {"created", detail::iso_time(submission.created)}};
  if (!submission.links.paper.empty()) one["paper"] = submission.links.paper;
  if (!submission.links.code.empty()) one["code"] = submission.links.code;
  if (submission.weights != Weights::kUnsaid) one["weights"] = enum_name(submission.weights);
  if (submission.walks_public) one["walks_public"] = true;
  const bool shown = view.visibility == Visibility::kAll ||
                     (view.visibility == Visibility::kBestRows && stands_for_team);
  if (view.visibility == Visibility::kImprovements && submission.shown) {
    one["means"][view.phase->primary]["mean"] = *submission.shown;
  } else if (!submission.score.empty() && shown) {
    const auto score = stored_score(submission);
    if (view.phase == nullptr || fits(score, *view.phase)) {
      one["means"] = score ? means_json(*score, view) : ordered_json::object();
    } else {
      one["withheld"] = "other-scorer";
    }
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

ordered_json columns_json(const Phase& phase) {
  return detail::json_list(phase.measures(), detail::column_json);
}

ordered_json published_json(const Phase& phase, std::size_t episodes, bool synthetic) {
  auto rows = ordered_json::array();
  for (const tasks::PublishedResult& one :
       tasks::published_beside(*phase.benchmark, phase.split, episodes, synthetic)) {
    ordered_json means = ordered_json::object();
    for (const tasks::Measure& measure : phase.measures()) {
      if (const auto value = one.value(measure.column)) means[measure.name]["mean"] = *value;
    }
    rows.push_back({{"agent", one.agent}, {"source", one.source}, {"means", std::move(means)}});
  }
  return rows;
}

std::string leaderboard_csv(const ordered_json& rows, const Phase& phase) {
  std::string out = "team,method,created";
  for (const tasks::Measure& measure : phase.measures()) {
    out += fmt::format(",{0},{0}_low,{0}_high", measure.name);
  }
  out += "\r\n";
  for (const ordered_json& row : rows) {
    out += fmt::format("{},{},{}", detail::sheet_text(row["team"].get<std::string>()),
                       detail::sheet_text(row["method"].get<std::string>()),
                       row["created"].get<std::string>());
    for (const tasks::Measure& measure : phase.measures()) {
      for (const char* part : {"mean", "low", "high"}) {
        out += "," + cell(row["means"], measure.name, part);
      }
    }
    out += "\r\n";
  }
  return out;
}

}  // namespace enfilade::service::evaluation
