// Teams, and logging in to the pages.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "enfilade/service/http/app.h"
#include "enfilade/service/http/bodies.h"

namespace enfilade::service::http {
namespace {

using nlohmann::ordered_json;

std::string principal_json(const accounts::Principal& who) {
  return ordered_json{{"role", to_string(who.role)}, {"name", who.name}}.dump();
}

Response register_team(Context& context, const Request& request) {
  if (!context.config.open_registration) {
    throw HttpError(403, "closed", "ask the organisers for a team");
  }
  const std::int64_t now = context.clock();
  context.registrations.take(request.address, now);
  const ordered_json body = parse_object(request.body);
  const std::string name = field(body, "name", true);
  const accounts::NewTeam team =
      accounts::add_team(*context.database, name, field(body, "contact", false), now);
  return json_response(ordered_json{{"id", team.id}, {"name", name}, {"token", team.token}}.dump(),
                       201);
}

Response log_in(Context& context, const Request& request) {
  const std::int64_t now = context.clock();
  const auto who = accounts::find_token(*context.database,
                                        field(parse_object(request.body), "token", true), now);
  if (!who) {
    context.failures.take(request.address, now);
    throw HttpError(401, "bad-token", "the token is unknown, expired or revoked");
  }
  // Workers come by a link, and their pages hold the token themselves: inside a frame of another
  // site there are no cookies.
  if (who->role == accounts::Role::kWorker) throw HttpError(403, "not-allowed", "not for workers");
  Response response = json_response(principal_json(*who));
  const bool tls = context.config.behind_proxy && request.header("x-forwarded-proto") == "https";
  response.headers.emplace_back(
      "Set-Cookie",
      fmt::format("{}={}; Path=/; Max-Age={}; HttpOnly; SameSite=Strict{}",
                  accounts::kSessionCookie, accounts::start_session(*context.database, *who, now),
                  accounts::kSessionSeconds, tls ? "; Secure" : ""));
  return response;
}

Response log_out(Context& context, const Request& request) {
  if (request.principal && request.principal->by_cookie) {
    accounts::end_sessions(*context.database, request.principal->token);
  }
  Response response = json_response("{}");
  response.headers.emplace_back(
      "Set-Cookie",
      fmt::format("{}=; Path=/; Max-Age=0; HttpOnly; SameSite=Strict", accounts::kSessionCookie));
  return response;
}

}  // namespace

void add_account_routes(Router& router, Context& context) {
  router.add({"POST", "/api/v1/teams", Access::kPublic,
              [&context](const Request& request) { return register_team(context, request); }});
  router.add({"POST", "/api/v1/session", Access::kPublic,
              [&context](const Request& request) { return log_in(context, request); }});
  router.add({"GET", "/api/v1/session", Access::kPublic, [](const Request& request) {
                return json_response(request.principal ? principal_json(*request.principal)
                                                       : R"({"role":"stranger"})");
              }});
  router.add({"DELETE", "/api/v1/session", Access::kPublic,
              [&context](const Request& request) { return log_out(context, request); }});
}

}  // namespace enfilade::service::http
