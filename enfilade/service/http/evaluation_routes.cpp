// Phases, submissions, leaderboards.
#include <fmt/format.h>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "enfilade/core/enum_names.h"
#include "enfilade/service/detail/json_list.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/evaluation/leaderboard.h"
#include "enfilade/service/http/routes.h"
#include "enfilade/tasks/files.h"

namespace enfilade::service::http {
namespace {

using accounts::Role;
using evaluation::Submission;
using evaluation::View;
using evaluation::Visibility;
using nlohmann::ordered_json;

/// A phase as the client sees it now.
View view_of(Context& context, const Request& request, const Phase* phase) {
  std::optional<Role> role;
  if (request.principal) role = request.principal->role;
  return evaluation::view_of(phase, role, phase != nullptr && context.submissions.is_final(*phase));
}

/// Submissions as the client sees them; each phase is looked at once.
class SubmissionViews {
 public:
  SubmissionViews(Context& context, const Request& request)
      : context_(context), request_(request) {}

  ordered_json json(const Submission& submission) {
    const PhaseView& phase = of(submission.phase);
    return evaluation::submission_json(submission, phase.view, phase.best.contains(submission.id));
  }

 private:
  struct PhaseView {
    View view;
    std::set<std::int64_t> best;  // submissions that stand for their teams, where it matters
  };

  const PhaseView& of(const std::string& name) {
    const auto [found, is_new] = seen_.try_emplace(name);
    PhaseView& made = found->second;
    if (!is_new) return made;
    const Phase* phase = context_.site->find_phase(name);
    made.view = view_of(context_, request_, phase);
    if (made.view.visibility != Visibility::kBestRows) return made;
    const auto scored = context_.submissions.scored(*phase);
    for (const Submission& one : evaluation::best_submissions(scored, made.view)) {
      made.best.insert(one.id);
    }
    return made;
  }

  Context& context_;
  const Request& request_;
  std::map<std::string, PhaseView> seen_;
};

/// null: no limit
ordered_json limit_json(std::optional<int> most) {
  return most ? ordered_json(*most) : ordered_json(nullptr);
}

/// In whole bits, rounded up: a bound stays one.
ordered_json bits_json(double bits) {
  constexpr double kTolerance = 1e-6;  // of sums of logarithms
  return std::isfinite(bits) ? ordered_json(std::ceil(bits - kTolerance)) : ordered_json(nullptr);
}

ordered_json leakage_json(const evaluation::Leakage& leakage, bool organiser) {
  ordered_json out{{"most_bits", bits_json(leakage.most)},
                   {"goal_bits", bits_json(leakage.goals)},
                   {"phases", leakage.phases}};
  if (organiser) out["used_bits"] = bits_json(leakage.used);
  return out;
}

ordered_json phase_json(Context& context, const Phase& phase, bool organiser) {
  ordered_json out{
      {"phase", phase.name},
      {"title", phase.title},
      {"split", phase.split},
      {"task", phase.benchmark->name},
      {"task_title", phase.benchmark->title},
      {"scorer", phase.scorer->name},
      {"episodes", count_episodes(context.site->secret_episodes(phase))},
      {"goals_secret", phase.goals_secret()},
      {"scores", enum_name(phase.scores)},
      {"primary", phase.primary},
      {"columns", evaluation::columns_json(phase)},
      {"ends", phase.ends ? ordered_json(detail::iso_time(*phase.ends)) : ordered_json(nullptr)},
      {"ended", context.submissions.has_ended(phase)},
      {"per_day", phase.per_day},
      {"per_team", limit_json(phase.per_team)},
      {"per_address_day", phase.per_address_day},
      {"per_address", limit_json(phase.per_address)}};
  if (!phase.rules.empty()) out["rules"] = phase.rules;
  if (!phase.goals_secret()) return out;
  out["step"] = phase.step;
  out["teams"] = phase.teams;
  out["leakage"] = leakage_json(context.submissions.leakage(phase), organiser);
  if (organiser) out["near_copies"] = context.submissions.count_near_copies(phase);
  return out;
}

Response phases(Context& context, const Request& request) {
  const bool organiser = request.is_from(Role::kOrganiser);
  const auto view = [&](const Phase& phase) { return phase_json(context, phase, organiser); };
  return json_response({{"registration", context.config.open_registration ? "open" : "closed"},
                        {"phases", detail::json_list(context.site->phases(), view)}});
}

Response receive(Context& context, const Request& request) {
  const evaluation::Receipt receipt =
      context.submissions.receive({request.principal->team,
                                   request.address,
                                   request.text("phase"),
                                   request.text("method"),
                                   {request.text("paper"), request.text("code")}},
                                  request.body);
  ordered_json out = SubmissionViews(context, request).json(receipt.submission);
  out["warnings"] = detail::json_list(receipt.warnings,
                                      [](const Diagnostic& warning) { return to_string(warning); });
  return json_response(out, receipt.known ? 200 : 202);
}

/// The submission of the path, if the client may see it.
Submission submission_of(Context& context, const Request& request) {
  constexpr const char* kMissing = "no such submission of this team";
  const auto found = context.submissions.find(request.id("id", kMissing));
  const accounts::Principal& principal = *request.principal;
  if (!found || (principal.role != Role::kOrganiser && found->team != principal.team)) {
    throw HttpError(404, kMissing);
  }
  return *found;
}

Response list_submissions(Context& context, const Request& request) {
  const accounts::Principal& principal = request.known_principal();
  if (principal.role != Role::kTeam && principal.role != Role::kOrganiser) {
    throw HttpError(403, "this is for a team or an organiser");
  }
  constexpr auto kMost = std::numeric_limits<std::int64_t>::max();
  const std::int64_t before = request.number("before", kMost, 1, kMost);
  SubmissionViews views(context, request);
  const auto view = [&views](const Submission& one) { return views.json(one); };
  return json_response(
      {{"submissions", detail::json_list(context.submissions.list(principal.team, before), view)}});
}

Response show_submission(Context& context, const Request& request) {
  request.known_principal();
  return json_response(SubmissionViews(context, request).json(submission_of(context, request)));
}

Response withdraw(Context& context, const Request& request) {
  context.submissions.withdraw(request.principal->team, submission_of(context, request).id);
  return json_response(ordered_json::object());
}

/// Why a phase's scores are not to be seen, for people.
std::string withheld_text(const Phase& phase) {
  if (phase.scores == Scores::kHidden) return "the scores of this phase are not public";
  if (!phase.ends) return "the scores of this phase appear when it has ended";
  return fmt::format("the scores of this phase appear when it has ended, at {}, and all are scored",
                     detail::iso_time(*phase.ends));
}

Response leaderboard(Context& context, const Request& request) {
  const Phase* phase = context.site->find_phase(request.parameter("phase"));
  if (phase == nullptr) throw HttpError(404, "no phase of this name");
  const View view = view_of(context, request, phase);
  if (view.visibility == Visibility::kNothing) throw HttpError(403, withheld_text(*phase));
  const ordered_json rows = evaluation::leaderboard_rows(context.submissions.scored(*phase), view,
                                                         request.text("all") == "1");
  if (request.text("format") == "csv") {
    return csv_response(evaluation::leaderboard_csv(rows, *phase));
  }
  return json_response({{"phase", phase->name},
                        {"title", phase->title},
                        {"split", phase->split},
                        {"task", phase->benchmark->name},
                        {"scorer", phase->scorer->name},
                        {"primary", phase->primary},
                        {"columns", evaluation::columns_json(*phase)},
                        {"synthetic", context.site->synthetic()},
                        {"rows", rows}});
}

}  // namespace

void add_evaluation_routes(Router& router, std::size_t most_bytes) {
  const std::string one = "/api/v1/submissions/{id}";
  router.add({"GET", "/api/v1/phases", Access::kPublic, phases});
  router.add({"POST", "/api/v1/submissions", Access::kTeam, receive, most_bytes});
  router.add({"GET", "/api/v1/submissions", Access::kPublic, list_submissions});
  router.add({"GET", one, Access::kPublic, show_submission});
  router.add({"DELETE", one, Access::kTeam, withdraw});
  router.add({"GET", "/api/v1/leaderboards/{phase}", Access::kPublic, leaderboard});
}

}  // namespace enfilade::service::http
