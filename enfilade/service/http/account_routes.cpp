// Teams, and logging in to the pages.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "enfilade/core/enum_names.h"
#include "enfilade/service/detail/addresses.h"
#include "enfilade/service/detail/json_list.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/http/headers.h"
#include "enfilade/service/http/routes.h"

namespace enfilade::service::http {
namespace {

using nlohmann::ordered_json;

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
Response register_team(Context& context, const Request& request) {
  const bool organiser = request.is_from(accounts::Role::kOrganiser);
  if (!organiser) {
    if (!context.config.open_registration) {
      throw HttpError(403, "registration is closed: ask the organisers for a team");
    }
    context.registrations.count(detail::address_group(request.address), context.db.now());
  }
  const ordered_json body = parse_object(request.body);
  const std::string name = text_field(body, "name");
  const accounts::NewTeam team =
      accounts::add_team(context.db, name, text_field(body, "contact", Presence::kOptional));
  if (organiser) accounts::set_approved(context.db, team.id, true);
  return json_response(
      {{"id", team.id}, {"name", name}, {"token", team.token}, {"approved", organiser}}, 201);
}

Response list_teams(Context& context, const Request& /*request*/) {
  return json_response({{"teams", detail::json_list(accounts::list_teams(context.db), team_json)}});
}

Response set_approval(Context& context, const Request& request) {
  constexpr const char* kMissing = "no such team";
  const std::int64_t id = request.id("team", kMissing);
  const ordered_json body = parse_object(request.body);
  const auto approved = body.find("approved");
  if (approved == body.end() || !approved->is_boolean()) {
    throw HttpError(400, "approved: must be there, and true or false");
  }
  if (!accounts::set_approved(context.db, id, approved->get<bool>())) {
    throw HttpError(404, kMissing);
  }
  return json_response(team_json(accounts::find_team(context.db, id).value()));
}

Response log_in(Context& context, const Request& request) {
  const auto principal =
      accounts::find_token(context.db, text_field(parse_object(request.body), "token"));
  if (!principal) {
    context.failures.count(request.address, context.db.now());
    throw HttpError(401, "the token is unknown, expired or revoked");
  }
  // Workers come by a link, and their pages keep the token: a frame inside another site has no
  // cookies.
  if (principal->role == accounts::Role::kWorker) throw HttpError(403, "not for workers");
  Response response = json_response(principal_json(*principal));
  set_cookie(response, accounts::start_session(context.db, *principal), accounts::kSessionSeconds,
             request, context.config);
  return response;
}

Response session(Context& context, const Request& request) {
  if (!request.principal) return json_response({{"role", "stranger"}});
  ordered_json out = principal_json(*request.principal);
  if (request.is_from(accounts::Role::kTeam)) {
    out["approved"] = accounts::is_approved(context.db, request.principal->team);
  }
  return json_response(out);
}

Response log_out(Context& context, const Request& request) {
  if (request.principal && request.principal->by_cookie) {
    accounts::end_sessions(context.db, request.principal->token);
  }
  Response response = json_response(ordered_json::object());
  set_cookie(response, "", 0, request, context.config);
  return response;
}

}  // namespace

void add_account_routes(Router& router) {
  router.add({"POST", "/api/v1/teams", Access::kPublic, register_team});
  router.add({"GET", "/api/v1/teams", Access::kOrganiser, list_teams});
  router.add({"PUT", "/api/v1/teams/{team}/approval", Access::kOrganiser, set_approval});
  router.add({"POST", "/api/v1/session", Access::kPublic, log_in});
  router.add({"GET", "/api/v1/session", Access::kPublic, session});
  router.add({"DELETE", "/api/v1/session", Access::kPublic, log_out});
}

}  // namespace enfilade::service::http
