// Teams, and logging in to the pages. Phases, submissions, leaderboards.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "enfilade/core/enum_names.h"
#include "enfilade/core/names.h"
#include "enfilade/service/detail/json_list.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/evaluation/breakdown.h"
#include "enfilade/service/evaluation/submissions.h"
#include "enfilade/service/http/messages.h"
#include "enfilade/service/http/routes.h"

namespace enfilade::service::http {
namespace {

using accounts::ClientRole;
using evaluation::PhaseView;
using evaluation::Submission;
using evaluation::Visibility;
using nlohmann::ordered_json;

constexpr const char* kNoSubmission = "no such submission";
constexpr std::size_t kMostOfMethod = 64U
                                      << 10U;  // bytes: two texts of 5,000 characters, and links

ordered_json principal_json(const accounts::Principal& principal) {
  return {{"role", enum_name(principal.role)}, {"name", principal.name}};
}

void set_cookie(Response& response, std::string_view secret, std::int64_t seconds,
                const Request& request, const ServerConfig& config) {
  response.add_header("Set-Cookie",
                      fmt::format("{}={}; Path=/; Max-Age={}; HttpOnly; SameSite=Strict{}",
                                  session_cookie(request, config), secret, seconds,
                                  is_encrypted(request, config) ? "; Secure" : ""));
}

ordered_json team_json(const accounts::Team& team) {
  return {{"id", team.id},
          {"name", team.name},
          {"contact", team.contact},
          {"created", detail::iso_time(team.created)},
          {"approved", team.approved.has_value()},
          {"submissions", team.submissions}};
}

/// An organiser makes a team whenever they like, and approves it by that.
Response register_team(RouteContext& context, const Request& request) {
  const bool organiser = request.is_from(accounts::ClientRole::kOrganiser);
  if (!organiser) {
    if (!context.config.open_registration) {
      throw HttpError(403, "registration is closed: ask the organisers for a team");
    }
    context.registrations.count(request.address, context.db.now());
  }
  Form form(request.body);
  const std::string name = form.text("name");
  const std::string contact = form.text("contact", Presence::kOptional);
  form.check();
  const accounts::NewTeam team = accounts::add_team(context.db, name, contact);
  if (organiser) accounts::set_approved(context.db, team.id, true);
  return json_response(
      {{"id", team.id}, {"name", name}, {"token", team.token}, {"approved", organiser}}, 201);
}

Response list_teams(RouteContext& context, const Request& /*request*/) {
  return json_response({{"teams", detail::json_list(accounts::list_teams(context.db), team_json)}});
}

Response set_approval(RouteContext& context, const Request& request) {
  constexpr const char* kMissing = "no such team";
  const std::int64_t id = request.id("team", kMissing);
  const ordered_json body = parse_object(request.body);
  const ordered_json& approved =
      form_field(body, "approved", &ordered_json::is_boolean, "true or false");
  if (!accounts::set_approved(context.db, id, approved.get<bool>())) {
    throw HttpError(404, kMissing);
  }
  return json_response(team_json(accounts::find_team(context.db, id).value()));
}

Response log_in(RouteContext& context, const Request& request) {
  const auto principal =
      accounts::find_token(context.db, text_field(parse_object(request.body), "token"));
  if (!principal) {
    context.failures.count(request.address, context.db.now());
    throw HttpError(401, "the token is unknown, expired or revoked");
  }
  // Workers come by a link, and their pages keep the token: a frame inside another site has no
  // cookies.
  if (principal->role == accounts::ClientRole::kWorker) throw HttpError(403, "not for workers");
  Response response = json_response(principal_json(*principal));
  set_cookie(response, accounts::start_session(context.db, *principal), accounts::kSessionSeconds,
             request, context.config);
  return response;
}

Response session(RouteContext& context, const Request& request) {
  if (!request.principal) return json_response({{"role", "stranger"}});
  ordered_json out = principal_json(*request.principal);
  if (request.is_from(accounts::ClientRole::kTeam)) {
    out["approved"] = accounts::is_approved(context.db, request.principal->team);
  }
  return json_response(out);
}

Response log_out(RouteContext& context, const Request& request) {
  if (request.principal && request.principal->by_cookie) {
    accounts::end_sessions(context.db, request.principal->token);
  }
  Response response = json_response(ordered_json::object());
  set_cookie(response, "", 0, request, context.config);
  return response;
}

/// A phase as the client sees it now.
PhaseView view_of(RouteContext& context, const Request& request, const Phase* phase) {
  const bool is_final = phase != nullptr && context.submissions.is_final(*phase);
  return evaluation::view_of(phase, request.role(), is_final);
}

/// Gives submissions as the client sees them; each phase is looked at once.
/// \pre context and request outlive it
auto viewer(RouteContext& context, const Request& request) {
  struct SeenPhase {
    PhaseView view;
    std::set<std::int64_t> best;  // submissions that stand for their teams, where it matters
  };
  return [&, seen = std::map<std::string, SeenPhase>()](const Submission& submission) mutable {
    const auto [found, is_new] = seen.try_emplace(submission.phase);
    SeenPhase& of = found->second;
    const Phase* phase = context.site->find_phase(submission.phase);
    if (is_new) of.view = view_of(context, request, phase);
    if (is_new && of.view.visibility == Visibility::kBestRows) {
      const auto scored = context.submissions.scored(*phase);
      for (const Submission& one : evaluation::best_submissions(scored, of.view)) {
        of.best.insert(one.id);
      }
    }
    return evaluation::submission_json(submission, of.view, of.best.contains(submission.id));
  };
}

/// null: no limit
ordered_json limit_json(std::optional<int> most) {
  return most ? ordered_json(*most) : ordered_json(nullptr);
}

/// In whole bits, rounded up: a bound stays one.
ordered_json bits_json(double bits) {
  constexpr double kTolerance = 1e-6;  // of sums of logarithms
  if (!std::isfinite(bits)) return nullptr;
  return std::ceil(bits - kTolerance) + 0.0;  // -0 becomes 0
}

ordered_json leakage_json(const evaluation::Leakage& leakage, bool organiser) {
  ordered_json out{{"most_bits", bits_json(leakage.most)},
                   {"goal_bits", bits_json(leakage.goals)},
                   {"gives_all", leakage.gives_all()},
                   {"phases", leakage.phases}};
  if (organiser) out["used_bits"] = bits_json(leakage.used);
  return out;
}

/// \param leakage of all phases with secret goals
ordered_json phase_json(RouteContext& context, const Phase& phase,
                        const std::map<std::string, evaluation::Leakage>& leakage, bool organiser) {
  ordered_json out{
      {"phase", phase.name},
      {"title", phase.title},
      {"split", phase.split},
      {"task", phase.benchmark->name},
      {"task_title", phase.benchmark->title},
      {"scorer", phase.scorer->name},
      {"episodes", context.site->secret_episodes(phase).split.size()},
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
  out["leakage"] = leakage_json(leakage.at(phase.name), organiser);
  if (organiser) out["near_copies"] = context.submissions.count_near_copies(phase);
  return out;
}

Response phases(RouteContext& context, const Request& request) {
  const bool organiser = request.is_from(ClientRole::kOrganiser);
  const auto leakage = context.submissions.leakage();
  const auto view = [&](const Phase& phase) {
    return phase_json(context, phase, leakage, organiser);
  };
  return json_response({{"registration", context.config.open_registration ? "open" : "closed"},
                        {"phases", detail::json_list(context.site->phases(), view)}});
}

/// 422, with the phase that the file can be sent to.
Response other_split(const evaluation::OtherSplit& fault) {
  Response response =
      error_response(422, "the file is of another split than the phase", fault.diagnostics());
  ordered_json body = ordered_json::parse(*response.body);
  body["error"]["phase"] = fault.phase();
  response.body = std::make_shared<const std::string>(body.dump());
  return response;
}

Response receive(RouteContext& context, const Request& request) {
  evaluation::Receipt receipt;
  try {
    receipt = context.submissions.receive({request.principal->team,
                                           request.address,
                                           request.text("phase"),
                                           request.text("method"),
                                           {request.text("paper"), request.text("code")}},
                                          request.body);
  } catch (const evaluation::OtherSplit& fault) {
    return other_split(fault);
  }
  ordered_json out = viewer(context, request)(receipt.submission);
  out["warnings"] = detail::json_list(receipt.warnings,
                                      [](const Diagnostic& warning) { return to_string(warning); });
  return json_response(out, receipt.known ? 200 : 202);
}

/// The submission of the path, if the client may see it.
Submission submission_of(RouteContext& context, const Request& request) {
  constexpr const char* kMissing = "no such submission of this team";
  const auto found = context.submissions.find(request.id("id", kMissing));
  const accounts::Principal& principal = *request.principal;
  if (!found || (principal.role != ClientRole::kOrganiser && found->team != principal.team)) {
    throw HttpError(404, kMissing);
  }
  return *found;
}

Response list_submissions(RouteContext& context, const Request& request) {
  const accounts::Principal& principal = request.known_principal();
  if (principal.role != ClientRole::kTeam && principal.role != ClientRole::kOrganiser) {
    throw HttpError(403, "this is for a team or an organiser");
  }
  constexpr auto kMost = std::numeric_limits<std::int64_t>::max();
  const std::int64_t before = request.number("before", kMost, 1, kMost);
  return json_response(
      {{"submissions", detail::json_list(context.submissions.list(principal.team, before),
                                         viewer(context, request))}});
}

Response show_submission(RouteContext& context, const Request& request) {
  request.known_principal();
  return json_response(viewer(context, request)(submission_of(context, request)));
}

Response withdraw(RouteContext& context, const Request& request) {
  context.submissions.withdraw(request.principal->team, submission_of(context, request).id);
  return json_response(ordered_json::object());
}

/// A submission, as the client may see it.
struct SeenSubmission {
  Submission submission;
  PhaseView view = {};
  bool ranked = false;  ///< it is among the rows that the client can see of the leaderboard
  bool own = false;     ///< the client is its team, or an organiser
};

/// Whether a submission is one of the leaderboard's rows, of all rows where all scores are seen.
bool is_ranked(RouteContext& context, const Submission& submission, const PhaseView& view) {
  if (view.phase == nullptr || view.visibility == Visibility::kNothing) return false;
  const auto rows =
      evaluation::best_submissions(context.submissions.scored(*view.phase), view, true);
  return std::ranges::find(rows, submission.id, &Submission::id) != rows.end();
}

/// The submission of that number. Others see those that the leaderboard shows, and nothing of the
/// rest, not even that they are there. \throws HttpError 404
SeenSubmission seen_submission(RouteContext& context, const Request& request, std::int64_t id) {
  const auto found = context.submissions.find(id);
  if (!found) throw HttpError(404, kNoSubmission);
  SeenSubmission seen{*found};
  seen.view = view_of(context, request, context.site->find_phase(found->phase));
  seen.ranked = is_ranked(context, *found, seen.view);
  seen.own = request.is_from(ClientRole::kOrganiser) ||
             (request.is_from(ClientRole::kTeam) && request.principal->team == found->team);
  if (!seen.own && !seen.ranked) throw HttpError(404, kNoSubmission);
  return seen;
}
SeenSubmission seen_submission(RouteContext& context, const Request& request) {
  return seen_submission(context, request, request.id("id", kNoSubmission));
}

/// Whether its scores are shown in parts: it has a place, and all scores of the phase are seen.
bool is_broken_down(RouteContext& context, const SeenSubmission& seen) {
  return seen.ranked && seen.view.visibility == Visibility::kAll &&
         evaluation::has_open_goals(*context.site, *seen.view.phase);
}
void require_broken_down(RouteContext& context, const SeenSubmission& seen) {
  if (is_broken_down(context, seen)) return;
  throw HttpError(403, "only means over the whole split are shown of this submission");
}

bool shows_walks(const SeenSubmission& seen) { return seen.own || seen.submission.walks_public; }

Response show_method(RouteContext& context, const Request& request) {
  const SeenSubmission seen = seen_submission(context, request);
  const auto said = context.submissions.description(seen.submission.id);
  ordered_json out = evaluation::submission_json(seen.submission, seen.view, seen.ranked);
  out["description"] = said.text;
  out["bibtex"] = said.bibtex;
  out["own"] = seen.own;
  out["broken_down"] = is_broken_down(context, seen);
  return json_response(out);
}

/// true or false of an object; false if absent
bool flag_field(const ordered_json& object, const char* name) {
  if (!object.contains(name)) return false;
  return form_field(object, name, &ordered_json::is_boolean, "true or false").get<bool>();
}

Response describe_method(RouteContext& context, const Request& request) {
  request.known_principal();
  const SeenSubmission seen = seen_submission(context, request);
  if (!seen.own) throw HttpError(403, "its team and organisers describe a method");
  const ordered_json body = parse_object(request.body);
  const auto text = [&body](const char* name) {
    return text_field(body, name, Presence::kOptional);
  };
  const std::string weights = text("weights");
  const auto said = find_enum<evaluation::Weights>(weights.empty() ? "unsaid" : weights);
  if (!said) {
    throw HttpError(400, fmt::format("weights: {}, not one of {}", quote(weights),
                                     fmt::join(enum_names<evaluation::Weights>(), ", ")));
  }
  context.submissions.describe(seen.submission, {text("description"),
                                                 text("bibtex"),
                                                 {text("paper"), text("code")},
                                                 *said,
                                                 flag_field(body, "walks_public")});
  return show_method(context, request);
}

Response breakdown(RouteContext& context, const Request& request) {
  const SeenSubmission seen = seen_submission(context, request);
  require_broken_down(context, seen);
  const Phase& phase = *seen.view.phase;
  ordered_json out = context.breakdowns.parts(seen.submission, phase);
  if (shows_walks(seen)) out["worst"] = context.breakdowns.worst(seen.submission, phase);
  return json_response(out);
}

Response submitted_episode(RouteContext& context, const Request& request) {
  const SeenSubmission seen = seen_submission(context, request);
  require_broken_down(context, seen);
  if (!shows_walks(seen)) throw HttpError(403, "its team does not show its trajectories");
  return json_response(
      context.breakdowns.episode(seen.submission, *seen.view.phase, request.parameter("episode")));
}

/// Differences of the means that the client sees: of secret goals nothing else is told.
ordered_json compare_shown(const SeenSubmission& first, const SeenSubmission& second) {
  ordered_json out{{"first", first.submission.id},
                   {"second", second.submission.id},
                   {"means", ordered_json::object()}};
  const auto means = [](const SeenSubmission& one) {
    const ordered_json json = evaluation::submission_json(one.submission, one.view, one.ranked);
    return json.value("means", ordered_json::object());
  };
  const ordered_json of_first = means(first), of_second = means(second);
  for (const auto& [name, mean] : of_first.items()) {
    if (!of_second.contains(name)) continue;
    const ordered_json &x = mean["mean"], &y = of_second[name]["mean"];
    if (!x.is_number() || !y.is_number()) continue;
    out["means"][name] = {{"first", x},
                          {"second", y},
                          {"difference", detail::rounded(y.get<double>() - x.get<double>())}};
  }
  return out;
}

Response compare_submissions(RouteContext& context, const Request& request) {
  constexpr auto kMost = std::numeric_limits<std::int64_t>::max();
  const auto seen = [&](const char* name) {
    const std::int64_t id = request.number(name, 0, 1, kMost);
    if (id == 0) throw HttpError(400, fmt::format("{}: must be there, a submission's id", name));
    const SeenSubmission one = seen_submission(context, request, id);
    if (one.submission.phase != request.parameter("phase") || !one.ranked) {
      throw HttpError(404, fmt::format("{}: no such row of this phase", name));
    }
    return one;
  };
  const SeenSubmission first = seen("first"), second = seen("second");
  if (!is_broken_down(context, first)) return json_response(compare_shown(first, second));
  return json_response(
      context.breakdowns.compare(first.submission, second.submission, *first.view.phase));
}

/// Why a phase's scores are not to be seen, for people.
std::string withheld_text(const Phase& phase) {
  if (phase.scores == Scores::kHidden) return "the scores of this phase are not public";
  if (!phase.ends) return "the scores of this phase appear when it has ended";
  return fmt::format("the scores of this phase appear when it has ended, at {}, and all are scored",
                     detail::iso_time(*phase.ends));
}

Response leaderboard(RouteContext& context, const Request& request) {
  const Phase* phase = context.site->find_phase(request.parameter("phase"));
  if (phase == nullptr) throw HttpError(404, "no phase of this name");
  const PhaseView view = view_of(context, request, phase);
  if (view.visibility == Visibility::kNothing) throw HttpError(403, withheld_text(*phase));
  const ordered_json rows = detail::json_list(
      evaluation::best_submissions(context.submissions.scored(*phase), view,
                                   request.text("all") == "1"),
      [&view](const Submission& one) { return evaluation::submission_json(one, view, true); });
  if (request.text("format") == "csv") {
    return csv_response(evaluation::leaderboard_csv(rows, *phase));
  }
  return json_response(
      {{"phase", phase->name},
       {"title", phase->title},
       {"split", phase->split},
       {"task", phase->benchmark->name},
       {"scorer", phase->scorer->name},
       {"primary", phase->primary},
       {"columns", evaluation::columns_json(*phase)},
       {"synthetic", context.site->synthetic()},
       {"rows", rows},
       {"published",
        evaluation::published_json(*phase, context.site->secret_episodes(*phase).split.size(),
                                   context.site->synthetic())}});
}

}  // namespace

void add_evaluation_routes(Router& router, std::size_t most_bytes) {
  router.add({"POST", "/api/v1/teams", Access::kPublic, register_team});
  router.add({"GET", "/api/v1/teams", Access::kOrganiser, list_teams});
  router.add({"PUT", "/api/v1/teams/{team}/approval", Access::kOrganiser, set_approval});
  router.add({"POST", "/api/v1/session", Access::kPublic, log_in});
  router.add({"GET", "/api/v1/session", Access::kPublic, session});
  router.add({"DELETE", "/api/v1/session", Access::kPublic, log_out});
  const std::string one = "/api/v1/submissions/{id}";
  router.add({"GET", "/api/v1/phases", Access::kPublic, phases});
  router.add({"POST", "/api/v1/submissions", Access::kTeam, receive, most_bytes});
  router.add({"GET", "/api/v1/submissions", Access::kPublic, list_submissions});
  router.add({"GET", one, Access::kPublic, show_submission});
  router.add({"DELETE", one, Access::kTeam, withdraw});
  router.add({"GET", one + "/method", Access::kPublic, show_method});
  router.add({"PUT", one + "/method", Access::kPublic, describe_method, kMostOfMethod});
  router.add({"GET", one + "/breakdown", Access::kPublic, breakdown});
  router.add({"GET", one + "/episodes/{episode}", Access::kPublic, submitted_episode});
  const std::string board = "/api/v1/leaderboards/{phase}";
  router.add({"GET", board, Access::kPublic, leaderboard});
  router.add({"GET", board + "/comparison", Access::kPublic, compare_submissions});
}

}  // namespace enfilade::service::http
