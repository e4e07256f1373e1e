#include "enfilade/service/http/app.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "enfilade/service/collecting/collections.h"
#include "enfilade/service/detail/clock.h"
#include "enfilade/service/detail/gzip.h"
#include "enfilade/service/http/headers.h"
#include "enfilade/service/http/web_files.h"

namespace enfilade::service::http {
namespace {

constexpr std::size_t kLongestPath = 512;
constexpr std::size_t kWorthCompressing = 1024;  // below, the headers are most of it

bool is_text(std::string_view type) {
  return type.starts_with("text/") || type.starts_with("application/json") ||
         type.starts_with("image/svg");
}

bool accepts_gzip(const Request& request) {
  const std::string_view accepted = request.header("accept-encoding");
  return accepted.find("gzip") != std::string_view::npos &&
         accepted.find("gzip;q=0") == std::string_view::npos;
}

void compress(const Request& request, Response& response) {
  if (!is_text(response.type) || response.body->size() < kWorthCompressing) return;
  for (const auto& [name, value] : response.headers) {
    if (name == "Content-Encoding") return;
  }
  response.headers.emplace_back("Vary", "Accept-Encoding");
  if (!accepts_gzip(request)) return;
  response.body = std::make_shared<const std::string>(detail::gzip(*response.body, 5));
  response.headers.emplace_back("Content-Encoding", "gzip");
}

/// 304 where the client has what would be sent.
void compare_with_cached(const Request& request, Response& response) {
  const std::string_view known = request.header("if-none-match");
  if (response.status != 200 || known.empty()) return;
  for (const auto& [name, value] : response.headers) {
    if (name != "ETag" || known.find(value) == std::string_view::npos) continue;
    response.status = 304;
    response.body = std::make_shared<const std::string>();
    return;
  }
}

std::string_view cookie_of(const Request& request, std::string_view name) {
  std::string_view rest = request.header("cookie");
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(';'), rest.size());
    std::string_view pair = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    pair.remove_prefix(std::min(pair.find_first_not_of(' '), pair.size()));
    if (pair.size() > name.size() && pair.starts_with(name) && pair[name.size()] == '=') {
      return pair.substr(name.size() + 1);
    }
  }
  return {};
}

bool may_call(Access access, accounts::Role role) {
  switch (access) {
    case Access::kPublic:
      return true;
    case Access::kTeam:
      return role == accounts::Role::kTeam;
    case Access::kOrganiser:
      return role == accounts::Role::kOrganiser;
    case Access::kReviewer:
      return role == accounts::Role::kOrganiser || role == accounts::Role::kReviewer;
    case Access::kWorker:
      return role == accounts::Role::kWorker;
  }
  return false;
}

std::string_view whom_for(Access access) {
  constexpr std::array<std::string_view, 5> kNames{"everybody", "a team", "an organiser",
                                                   "a reviewer or an organiser", "a worker"};
  return kNames[static_cast<std::size_t>(access)];
}

void check_access(const Route& route, const Request& request) {
  if (route.access == Access::kPublic) return;
  if (!request.principal) {
    throw HttpError(401, "who-are-you", "this needs a token: Authorization: Bearer enfilade_...");
  }
  if (!may_call(route.access, request.principal->role)) {
    throw HttpError(403, "not-allowed", fmt::format("this is for {}", whom_for(route.access)));
  }
}

/// A page of another site can make a browser send its cookie, or log it in as somebody else, but
/// neither send X-Enfilade nor keep the browser from saying where it comes from.
void check_origin(const Request& request) {
  if (request.method == "GET") return;
  const std::string_view site = request.header("sec-fetch-site");  // other clients send none
  if (!site.empty() && site != "same-origin" && site != "none") {
    throw HttpError(403, "cross-site", "this page is of another site");
  }
  const bool by_cookie = request.principal && request.principal->by_cookie;
  if (by_cookie && request.header("x-enfilade").empty()) {
    throw HttpError(403, "cross-site", "requests with a cookie need the header X-Enfilade: 1");
  }
}

Context make_context(const std::shared_ptr<const Site>& site, ServerConfig config) {
  auto database = std::make_shared<store::Database>(config.database);
  const detail::Clock clock = config.clock ? config.clock : detail::system_clock();
  const int most = config.most_attempts;
  const int most_joins = config.most_joins;
  return Context{site,
                 database,
                 std::move(config),
                 clock,
                 browsing::Faces(site->panoramas()),
                 evaluation::Evaluation(site, database, clock),
                 Metrics(),
                 RateLimit(most),
                 RateLimit(most),
                 RateLimit(most_joins)};
}

/// Mechanical Turk shows a collection's page in a frame of its own, and takes its form.
void open_to_platform(store::Database& database, const Request& request, Response& response) {
  const auto collection = collecting::find_collection(database, request.text("collection"));
  if (!collection || collection->platform.kind != collecting::PlatformKind::kMturk) return;
  const std::string origins = fmt::format("{}", fmt::join(collection->platform.origins, " "));
  response.headers.emplace_back("Content-Security-Policy",
                                content_policy("'self' " + origins, origins));
  response.frameable = true;
}

Response error_of(const std::exception_ptr& thrown, std::string& fault) {
  try {
    std::rethrow_exception(thrown);
  } catch (const HttpError& error) {
    return error_response(error.status(), error.code(), error.what());
  } catch (const InvalidInput& error) {
    return error_response(422, "invalid-input", "what was sent has faults", error.diagnostics());
  } catch (const std::exception& error) {
    fault = error.what();  // names files of this machine: for the log, not for strangers
  } catch (...) {
    fault = "an exception of no known type";
  }
  return error_response(500, "internal", "the server failed; its log says why");
}

}  // namespace

void RateLimit::take(const std::string& address, std::int64_t now) {
  constexpr std::size_t kMostAddresses = 10'000;
  const std::int64_t minute = now / 60;
  const std::scoped_lock lock(mutex_);
  if (windows_.size() > kMostAddresses) windows_.clear();
  Window& window = windows_[address];
  if (window.minute != minute) window = {minute, 0};
  if (++window.count > most_) {
    throw HttpError(429, "too-many", "too many attempts from this address; wait a minute");
  }
}

App::App(const std::shared_ptr<const Site>& site, ServerConfig config)
    : context_(make_context(site, std::move(config))) {
  add_scan_routes(router_, context_);
  add_episode_routes(router_, context_);
  add_account_routes(router_, context_);
  add_evaluation_routes(router_, context_);
  add_collection_routes(router_, context_);
  add_review_routes(router_, context_);
  add_work_routes(router_, context_);
  add_operation_routes(router_, context_);
}

void App::identify(Request& request) {
  constexpr std::string_view kBearer = "Bearer ";
  const std::int64_t now = context_.clock();
  const std::string_view authorization = request.header("authorization");
  if (!authorization.empty()) {
    if (authorization.starts_with(kBearer)) {
      request.principal =
          accounts::find_token(*context_.database, authorization.substr(kBearer.size()), now);
    }
    if (!request.principal) {
      context_.failures.take(request.address, now);
      throw HttpError(401, "bad-token", "the token is unknown, expired or revoked");
    }
    return;
  }
  const std::string_view cookie = cookie_of(request, accounts::kSessionCookie);
  if (!cookie.empty()) request.principal = accounts::find_session(*context_.database, cookie, now);
}

// "/leaderboard" is the file /leaderboard.html. Names of assets change with their content.
Response App::page(const Request& request) const {
  std::string path = request.path == "/" ? "/index" : request.path;
  if (path.find('.') == std::string::npos) path += ".html";
  const auto files = web_files();
  const auto found = std::ranges::lower_bound(files, path, {}, &WebFile::path);
  if (found == files.end() || found->path != path) {
    if (request.path == "/" && files.empty()) {
      Response none;
      none.type = "text/plain; charset=utf-8";
      none.body = std::make_shared<const std::string>(
          "This build of Enfilade has no web client in it: npm was not there. The API is at "
          "/api/v1/, its description at /api/v1/openapi.json\n");
      return none;
    }
    throw HttpError(404, "not-found", "there is nothing here");
  }
  Response response;
  response.type = found->type;
  const bool packed = accepts_gzip(request);
  response.body = std::make_shared<const std::string>(packed ? std::string(found->gzip)
                                                             : detail::gunzip(found->gzip));
  if (packed) response.headers.emplace_back("Content-Encoding", "gzip");
  response.headers.emplace_back("Vary", "Accept-Encoding");
  response.headers.emplace_back("ETag", fmt::format("\"{}\"", found->digest));
  response.headers.emplace_back("Cache-Control", path.starts_with("/assets/")
                                                     ? "public, max-age=31536000, immutable"
                                                     : "no-cache");
  if (path == "/collect.html" || path == "/walk.html") {
    open_to_platform(*context_.database, request, response);
  }
  return response;
}

Response App::answer(Request& request, const BodyReader& read_body, std::string_view& pattern) {
  if (request.path.size() > kLongestPath) throw HttpError(414, "long-path", "the path is too long");
  Router::Match match = router_.find(request.method, request.path);
  if (match.route == nullptr) {
    if (match.other_method) throw HttpError(405, "bad-method", "not with this method");
    if (request.method != "GET") throw HttpError(404, "not-found", "there is nothing here");
    return page(request);
  }
  pattern = match.route->pattern;
  request.parameters = std::move(match.parameters);
  identify(request);
  check_access(*match.route, request);
  check_origin(request);
  // Only now: what a stranger sends to a team's route is not worth keeping.
  if (read_body) request.body = read_body(match.route->most_bytes);
  return match.route->handle(request);
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
    response = error_of(std::current_exception(), fault);
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
