// Teams, and logging in to the pages.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "enfilade/service/detail/names.h"
#include "enfilade/service/http/routes.h"

namespace enfilade::service::http {
namespace {

using nlohmann::ordered_json;

ordered_json principal_json(const accounts::Principal& principal) {
  return {{"role", detail::name_of(principal.role)}, {"name", principal.name}};
}

void set_cookie(Response& response, std::string_view secret, std::int64_t seconds, bool secure) {
  response.add_header(
      "Set-Cookie",
      fmt::format("{}={}; Path=/; Max-Age={}; HttpOnly; SameSite=Strict{}",
                  accounts::kSessionCookie, secret, seconds, secure ? "; Secure" : ""));
}

Response register_team(Context& context, const Request& request) {
  if (!context.config.open_registration) {
    throw HttpError(403, "ask the organisers for a team");
  }
  context.registrations.count(request.address, context.db.now());
  const ordered_json body = parse_object(request.body);
  const std::string name = text_field(body, "name");
  const accounts::NewTeam team =
      accounts::add_team(context.db, name, text_field(body, "contact", Presence::kOptional));
  return json_response({{"id", team.id}, {"name", name}, {"token", team.token}}, 201);
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
  const bool tls = context.config.behind_proxy && request.header("x-forwarded-proto") == "https";
  set_cookie(response, accounts::start_session(context.db, *principal), accounts::kSessionSeconds,
             tls);
  return response;
}

Response session(Context& /*context*/, const Request& request) {
  return json_response(request.principal ? principal_json(*request.principal)
                                         : ordered_json{{"role", "stranger"}});
}

Response log_out(Context& context, const Request& request) {
  if (request.principal && request.principal->by_cookie) {
    accounts::end_sessions(context.db, request.principal->token);
  }
  Response response = json_response(ordered_json::object());
  set_cookie(response, "", 0, false);
  return response;
}

}  // namespace

void add_account_routes(Router& router) {
  router.add({"POST", "/api/v1/teams", Access::kPublic, register_team});
  router.add({"POST", "/api/v1/session", Access::kPublic, log_in});
  router.add({"GET", "/api/v1/session", Access::kPublic, session});
  router.add({"DELETE", "/api/v1/session", Access::kPublic, log_out});
}

}  // namespace enfilade::service::http
