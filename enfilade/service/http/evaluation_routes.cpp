// Phases, submissions, leaderboards. Of scores, only means over a whole split leave the server: one
// episode's navigation error would tell where its goal is.
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "enfilade/service/detail/clock.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/http/app.h"

namespace enfilade::service::http {
namespace {

using nlohmann::ordered_json;

/// What a leaderboard shows: the table's columns in their order, names of r2r::metric_fields().
constexpr std::array<const char*, 8> kColumns{"trajectory_length", "nav_error", "success",
                                              "oracle_success",    "spl",       "ndtw_collapsed",
                                              "sdtw_collapsed",    "cls"};

const Phase& phase_of(const Context& context, std::string_view name) {
  const Phase* phase = context.site->find_phase(name);
  if (phase == nullptr) throw HttpError(404, "unknown-phase", "no phase of this name");
  return *phase;
}

/// How much of a submission's scores somebody gets to see.
enum class Sight { kNone, kRounded, kExact };

// Two files that differ in one episode have means that differ by its error alone, which tells how
// far its goal is. Rounded as papers do, they don't, in a split of hundreds.
Sight sight_of(const Context& context, const Request& request, std::string_view phase_name) {
  if (request.principal && request.principal->role == accounts::Role::kOrganiser)
    return Sight::kExact;
  const Phase* phase = context.site->find_phase(phase_name);
  if (phase == nullptr || phase->scores == Scores::kHidden) return Sight::kNone;
  return phase->goals_secret() ? Sight::kRounded : Sight::kExact;
}

std::string phase_list_json(const Context& context) {
  auto list = ordered_json::array();
  for (const Phase& phase : context.site->phases()) {
    list.push_back({{"phase", phase.name},
                    {"title", phase.title},
                    {"split", phase.split},
                    {"episodes", context.site->secret_episodes(phase).episodes.size()},
                    {"goals_secret", phase.goals_secret()},
                    {"scores", phase.scores == Scores::kPublic ? "public" : "hidden"},
                    {"per_day", phase.per_day}});
  }
  return ordered_json{{"phases", list}}.dump();
}

/// To 0.01 m, or 0.1 %.
void round_mean(std::string_view column, ordered_json& mean) {
  const double parts = column == "trajectory_length" || column == "nav_error" ? 100 : 1000;
  for (ordered_json& value : mean) {  // the mean and its interval; null if infinite
    if (value.is_number()) value = std::round(value.get<double>() * parts) / parts;
  }
}

ordered_json columns_json(const evaluation::Submission& submission, Sight sight) {
  const ordered_json score = ordered_json::parse(submission.score);
  ordered_json means;
  for (const char* column : kColumns) {
    means[column] = score.at("means").at(column);
    if (sight == Sight::kRounded) round_mean(column, means[column]);
  }
  return means;
}

ordered_json submission_json(const evaluation::Submission& submission, Sight sight) {
  ordered_json one{{"id", submission.id},       {"team", submission.team_name},
                   {"phase", submission.phase}, {"method", submission.method},
                   {"state", submission.state}, {"created", detail::iso_time(submission.created)}};
  if (!submission.score.empty() && sight != Sight::kNone) {
    one["means"] = columns_json(submission, sight);
  }
  return one;
}

Response receive(Context& context, const Request& request) {
  const evaluation::Receipt receipt = context.evaluation.receive(
      *request.principal, request.text("phase"), request.text("method"), request.body);
  const evaluation::Submission& submission = receipt.submission;
  ordered_json out = submission_json(submission, sight_of(context, request, submission.phase));
  auto& warnings = out["warnings"] = ordered_json::array();
  for (const Diagnostic& warning : receipt.warnings) warnings.push_back(to_string(warning));
  return json_response(out.dump(), receipt.seen_before ? 200 : 202);
}

/// The row, if it is the asker's to see.
evaluation::Submission own_submission(const Context& context, const Request& request) {
  if (const auto id = parse_number(request.parameter("id"))) {
    auto found = context.evaluation.find(*id);
    const accounts::Principal& who = *request.principal;
    if (found && (who.role == accounts::Role::kOrganiser || found->team == who.team)) return *found;
  }
  throw HttpError(404, "unknown-submission", "no such submission of this team");
}

const accounts::Principal& known(const Request& request) {
  if (!request.principal) throw HttpError(401, "who-are-you", "this needs a token");
  return *request.principal;
}

Response list_submissions(const Context& context, const Request& request) {
  const accounts::Principal& who = known(request);
  if (who.role != accounts::Role::kTeam && who.role != accounts::Role::kOrganiser) {
    throw HttpError(403, "not-allowed", "this is for a team or an organiser");
  }
  const std::int64_t team = who.team;  // 0, everybody's, for organisers
  constexpr auto kMost = std::numeric_limits<std::int64_t>::max();
  const std::int64_t before = request.number("before", kMost, 1, kMost);
  auto list = ordered_json::array();
  for (const evaluation::Submission& submission : context.evaluation.list(team, before)) {
    list.push_back(submission_json(submission, sight_of(context, request, submission.phase)));
  }
  return json_response(ordered_json{{"submissions", list}}.dump());
}

double spl_of(const ordered_json& row) { return row["means"]["spl"]["mean"].get<double>(); }

/// Rows by falling SPL, earlier ones first where equal; of each team its best, or all.
ordered_json leaderboard_rows(const Context& context, const Phase& phase, Sight sight, bool all) {
  std::vector<ordered_json> rows;
  for (const evaluation::Submission& submission : context.evaluation.scored(phase)) {
    rows.push_back(submission_json(submission, sight));
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
      for (const char* part : {"mean", "low", "high"})
        out += "," + row["means"][column][part].dump();
    }
    out += "\r\n";
  }
  return out;
}

Response leaderboard(const Context& context, const Request& request) {
  const Phase& phase = phase_of(context, request.parameter("phase"));
  const Sight sight = sight_of(context, request, phase.name);
  if (sight == Sight::kNone) {
    throw HttpError(403, "hidden-scores", "the scores of this phase are not public");
  }
  const ordered_json rows = leaderboard_rows(context, phase, sight, request.text("all") == "1");
  if (request.text("format") == "csv") {
    return csv_response(leaderboard_csv(rows));
  }
  return json_response(ordered_json{
      {"phase", phase.name},
      {"title", phase.title},
      {"split", phase.split},
      {"synthetic", context.site->synthetic()},
      {"rows", rows}}.dump());
}

}  // namespace

void add_evaluation_routes(Router& router, Context& context) {
  router.add({"GET", "/api/v1/phases", Access::kPublic,
              [&context](const Request&) { return json_response(phase_list_json(context)); }});
  router.add({"POST", "/api/v1/submissions", Access::kTeam,
              [&context](const Request& request) { return receive(context, request); },
              context.config.most_submission_bytes});
  router.add({"GET", "/api/v1/submissions", Access::kPublic,
              [&context](const Request& request) { return list_submissions(context, request); }});
  router.add(
      {"GET", "/api/v1/submissions/{id}", Access::kPublic, [&context](const Request& request) {
         known(request);
         const evaluation::Submission found = own_submission(context, request);
         const Sight sight = sight_of(context, request, found.phase);
         return json_response(submission_json(found, sight).dump());
       }});
  router.add(
      {"DELETE", "/api/v1/submissions/{id}", Access::kTeam, [&context](const Request& request) {
         const evaluation::Submission found = own_submission(context, request);
         context.evaluation.withdraw(request.principal->team, found.id);
         return json_response("{}");
       }});
  router.add({"GET", "/api/v1/leaderboards/{phase}", Access::kPublic,
              [&context](const Request& request) { return leaderboard(context, request); }});
}

}  // namespace enfilade::service::http
