// Teams, and logging in to the pages.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "enfilade/service/detail/app.h"

namespace enfilade::service::detail {
namespace {

using nlohmann::ordered_json;

/// A field of the body's object. \throws HttpError 400 if it is no text
std::string field(const ordered_json& object, const char* name, bool required) {
  const auto found = object.find(name);
  if (found == object.end() && !required) return {};
  if (found == object.end() || !found->is_string()) {
    throw HttpError(400, "bad-body", fmt::format("{}: must be there, and a text", name));
  }
  return found->get<std::string>();
}

ordered_json parse_object(const std::string& body) {
  ordered_json object = ordered_json::parse(body, nullptr, false);
  if (!object.is_object()) throw HttpError(400, "bad-body", "the body is not a JSON object");
  return object;
}

std::string principal_json(const Principal& who) {
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
  const NewTeam team = add_team(*context.database, name, field(body, "contact", false), now);
  return json_response(ordered_json{{"id", team.id}, {"name", name}, {"token", team.token}}.dump(),
                       201);
}

Response log_in(Context& context, const Request& request) {
  const std::int64_t now = context.clock();
  const auto who =
      find_token(*context.database, field(parse_object(request.body), "token", true), now);
  if (!who) {
    context.failures.take(request.address, now);
    throw HttpError(401, "bad-token", "the token is unknown, expired or revoked");
  }
  Response response = json_response(principal_json(*who));
  const bool tls = context.config.behind_proxy && request.header("x-forwarded-proto") == "https";
  response.headers.emplace_back(
      "Set-Cookie", fmt::format("{}={}; Path=/; Max-Age={}; HttpOnly; SameSite=Strict{}",
                                kSessionCookie, start_session(*context.database, *who, now),
                                kSessionSeconds, tls ? "; Secure" : ""));
  return response;
}

Response log_out(Context& context, const Request& request) {
  if (request.principal && request.principal->by_cookie) {
    end_sessions(*context.database, request.principal->token);
  }
  Response response = json_response("{}");
  response.headers.emplace_back(
      "Set-Cookie",
      fmt::format("{}=; Path=/; Max-Age=0; HttpOnly; SameSite=Strict", kSessionCookie));
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

}  // namespace enfilade::service::detail
