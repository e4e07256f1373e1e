// Phases, submissions, leaderboards.
#include <limits>
#include <nlohmann/json.hpp>

#include "enfilade/service/detail/json_list.h"
#include "enfilade/service/evaluation/leaderboard.h"
#include "enfilade/service/http/routes.h"

namespace enfilade::service::http {
namespace {

using accounts::Role;
using evaluation::Submission;
using evaluation::Visibility;
using nlohmann::ordered_json;

Visibility visibility_to(const Context& context, const Request& request,
                         std::string_view phase_name) {
  std::optional<Role> role;
  if (request.principal) role = request.principal->role;
  return evaluation::visibility_of(context.site->find_phase(phase_name), role);
}

ordered_json submission_json(const Context& context, const Request& request,
                             const Submission& submission) {
  return evaluation::submission_json(submission, visibility_to(context, request, submission.phase));
}

Response phases(Context& context, const Request& /*request*/) {
  const auto view = [&site = *context.site](const Phase& phase) {
    return ordered_json{{"phase", phase.name},
                        {"title", phase.title},
                        {"split", phase.split},
                        {"episodes", site.secret_episodes(phase).episodes.size()},
                        {"goals_secret", phase.goals_secret()},
                        {"scores", phase.scores == Scores::kPublic ? "public" : "hidden"},
                        {"per_day", phase.per_day}};
  };
  return json_response({{"phases", detail::json_list(context.site->phases(), view)}});
}

Response receive(Context& context, const Request& request) {
  const evaluation::Receipt receipt = context.submissions.receive(
      *request.principal, request.text("phase"), request.text("method"), request.body);
  ordered_json out = submission_json(context, request, receipt.submission);
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
  const auto view = [&](const Submission& one) { return submission_json(context, request, one); };
  return json_response(
      {{"submissions", detail::json_list(context.submissions.list(principal.team, before), view)}});
}

Response show_submission(Context& context, const Request& request) {
  request.known_principal();
  return json_response(submission_json(context, request, submission_of(context, request)));
}

Response withdraw(Context& context, const Request& request) {
  context.submissions.withdraw(request.principal->team, submission_of(context, request).id);
  return json_response(ordered_json::object());
}

Response leaderboard(Context& context, const Request& request) {
  const Phase* phase = context.site->find_phase(request.parameter("phase"));
  if (phase == nullptr) throw HttpError(404, "no phase of this name");
  const Visibility visibility = visibility_to(context, request, phase->name);
  if (visibility == Visibility::kHidden) {
    throw HttpError(403, "the scores of this phase are not public");
  }
  const ordered_json rows = evaluation::leaderboard_rows(context.submissions.scored(*phase),
                                                         visibility, request.text("all") == "1");
  if (request.text("format") == "csv") return csv_response(evaluation::leaderboard_csv(rows));
  return json_response({{"phase", phase->name},
                        {"title", phase->title},
                        {"split", phase->split},
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
