#include "enfilade/service/http/app.h"

#include <algorithm>
#include <chrono>
#include <ranges>
#include <utility>

#include "enfilade/service/http/headers.h"
#include "enfilade/service/http/routes.h"

namespace enfilade::service::http {
namespace {

constexpr std::size_t kLongestPath = 512;

std::string_view cookie_of(const Request& request, std::string_view name) {
  for (const auto part : std::views::split(request.header("cookie"), ';')) {
    std::string_view pair(part.begin(), part.end());
    pair.remove_prefix(std::min(pair.find_first_not_of(' '), pair.size()));
    if (pair.size() > name.size() && pair.starts_with(name) && pair[name.size()] == '=') {
      return pair.substr(name.size() + 1);
    }
  }
  return {};
}

/// A page of another site can make a browser send its cookie, or log it in as somebody else, but
/// can neither send X-Enfilade nor keep the browser from saying where the request comes from.
void check_origin(const Request& request) {
  if (request.method == "GET") return;
  const std::string_view site = request.header("sec-fetch-site");  // other clients send none
  if (!site.empty() && site != "same-origin" && site != "none") {
    throw HttpError(403, "this page is of another site");
  }
  const bool by_cookie = request.principal && request.principal->by_cookie;
  if (by_cookie && request.header("x-enfilade").empty()) {
    throw HttpError(403, "requests with a cookie need the header X-Enfilade: 1");
  }
}

}  // namespace

App::App(std::shared_ptr<const Site> site, ServerConfig config)
    : context_{std::move(site), std::move(config)} {
  const std::size_t most_bytes = context_.config.most_submission_bytes;
  add_browsing_routes(router_);
  add_account_routes(router_);
  add_evaluation_routes(router_, most_bytes);
  add_collection_routes(router_, most_bytes);
  add_review_routes(router_);
  add_work_routes(router_);
  add_operation_routes(router_);
}

void App::identify(Request& request) {
  constexpr std::string_view kBearer = "Bearer ";
  const std::string_view authorization = request.header("authorization");
  if (!authorization.empty()) {
    if (authorization.starts_with(kBearer)) {
      request.principal = accounts::find_token(context_.db, authorization.substr(kBearer.size()));
    }
    if (!request.principal) {
      context_.failures.count(request.address, context_.db.now());
      throw HttpError(401, "the token is unknown, expired or revoked");
    }
    return;
  }
  const std::string_view cookie = cookie_of(request, accounts::kSessionCookie);
  if (!cookie.empty()) {
    request.principal = accounts::find_session(context_.db, cookie);
  }
}

Response App::answer(Request& request, const BodyReader& read_body, std::string_view& pattern) {
  if (request.path.size() > kLongestPath) throw HttpError(414, "the path is too long");
  Router::Match match = router_.find(request.method, request.path);
  if (match.route == nullptr) {
    if (match.other_method) throw HttpError(405, "not with this method");
    if (request.method != "GET") throw HttpError(404, "there is nothing here");
    return page(context_, request);
  }
  pattern = match.route->pattern;
  request.parameters = std::move(match.parameters);
  identify(request);
  check_access(*match.route, request);
  check_origin(request);
  // Only now: the body of a client that may not call the route is never kept in memory.
  if (read_body) request.body = read_body(match.route->most_bytes);
  return match.route->handle(context_, request);
}

Response App::handle(Request request, const BodyReader& read_body) {
  const auto begin = std::chrono::steady_clock::now();
  context_.metrics.begin();
  std::string fault;
  std::string_view pattern = "(page)";
  Response response;
  try {
    response = answer(request, read_body, pattern);
  } catch (...) {
    response = error_response(std::current_exception(), fault);
  }
  compare_with_cached(request, response);
  compress(request, response);
  add_security_headers(response);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  context_.metrics.count(pattern, response.status, took.count());
  context_.metrics.end();
  if (context_.config.log) {
    context_.config.log(
        {request.address, request.method, request.path, response.status, response.body->size(),
         took.count(),
         request.principal ? std::string_view(request.principal->name) : std::string_view(),
         fault});
  }
  return response;
}

}  // namespace enfilade::service::http
