#include "enfilade/service/http/routes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>
#include <iterator>
#include <ranges>
#include <utility>

#include "enfilade/net/hosts.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/http/messages.h"

namespace enfilade::service::http {
namespace {

using accounts::ClientRole;

bool is_placeholder(std::string_view part) {
  return part.size() > 2 && part.front() == '{' && part.back() == '}';
}

/// The parts between slashes: "/a/b" -> a, b.
std::vector<std::string_view> split_path(std::string_view path) {
  std::vector<std::string_view> parts;
  if (path.starts_with('/')) path.remove_prefix(1);
  for (const auto part : std::views::split(path, '/')) parts.emplace_back(part.begin(), part.end());
  return parts;
}

/// Who may call a route: for people, and by ClientRole.
struct Audience {
  std::string_view name;
  std::array<bool, names_of(ClientRole{}).size()> roles;
};
/// By Access.
constexpr std::array<Audience, 5> kAudiences{
    {{"everybody", {true, true, true, true}},
     {"a team", {true, false, false, false}},
     {"an organiser", {false, true, false, false}},
     {"a reviewer or an organiser", {false, true, true, false}},
     {"a worker", {false, false, false, true}}}};

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

/// The token of "Bearer TOKEN", where the first word may be in any case (RFC 9110, 11.1); empty for
/// anything else.
std::string_view bearer_token(std::string_view authorization) {
  constexpr std::string_view kScheme = "bearer ";
  if (authorization.size() < kScheme.size()) return {};
  const std::string scheme(authorization.substr(0, kScheme.size()));
  if (lower_case(scheme) != kScheme) return {};
  authorization.remove_prefix(kScheme.size());
  authorization.remove_prefix(std::min(authorization.find_first_not_of(' '), authorization.size()));
  return authorization;
}

/// \param methods  that there are: with GET, HEAD comes by itself
Response wrong_method(std::vector<std::string> methods) {
  if (std::ranges::find(methods, "GET") != methods.end()) methods.emplace_back("HEAD");
  const std::string allowed = fmt::format("{}", fmt::join(methods, ", "));
  Response response = error_response(405, "not with this method; allowed: " + allowed);
  response.add_header("Allow", allowed);
  return response;
}

}  // namespace

void check_access(const HttpRoute& route, const Request& request) {
  if (route.access == Access::kPublic) return;
  const Audience& audience = kAudiences[static_cast<std::size_t>(route.access)];
  if (!audience.roles[static_cast<std::size_t>(request.known_principal().role)]) {
    throw HttpError(403, fmt::format("this is for {}", audience.name));
  }
}

Router::Match Router::find(std::string_view method, std::string_view path) const {
  Match match;
  const std::vector<std::string_view> parts = split_path(path);
  for (const HttpRoute& route : routes_) {
    const std::vector<std::string_view> pattern = split_path(route.pattern);
    const bool fits = std::ranges::equal(parts, pattern, [](auto part, auto wanted) {
      return is_placeholder(wanted) ? !part.empty() : part == wanted;
    });
    if (!fits) continue;
    if (route.method != method) {
      match.methods.push_back(route.method);
      continue;
    }
    match.route = &route;
    for (std::size_t k = 0; k < parts.size(); ++k) {
      if (!is_placeholder(pattern[k])) continue;
      match.parameters.emplace(pattern[k].substr(1, pattern[k].size() - 2), parts[k]);
    }
    return match;
  }
  return match;
}

std::function<void(std::string_view)> fault_log(const ServerConfig& config, std::string_view method,
                                                int status) {
  if (!config.log) return {};
  return [log = config.log, method, status](std::string_view fault) {
    RequestRecord record;
    record.address = "-";
    record.method = method;
    record.status = fault.empty() ? 200 : status;
    record.fault = fault;
    log(record);
  };
}

void RateLimit::count(const std::string& address, std::int64_t now) {
  constexpr std::size_t kMostAddresses = 10'000;
  const std::int64_t minute = now / 60;
  const std::scoped_lock lock(mutex_);
  if (windows_.size() > kMostAddresses) {
    std::erase_if(windows_, [minute](const auto& one) { return one.second.minute != minute; });
  }
  if (windows_.size() > kMostAddresses) windows_.clear();
  Window& window = windows_[net::address_group(address)];
  if (window.minute != minute) window = {minute, 0};
  if (++window.count > most_) {
    throw HttpError(429, "too many attempts from this address; wait a minute");
  }
}

void Metrics::count(std::string_view route, int status, double seconds) {
  const std::scoped_lock lock(mutex_);
  ++counts_[{std::string(route), status}];
  Times& times = times_[std::string(route)];
  const auto bound = std::ranges::lower_bound(kBounds, seconds);
  ++times.buckets[static_cast<std::size_t>(bound - kBounds.begin())];
  times.sum += seconds;
}

std::string Metrics::text(const std::map<std::string, double>& gauges) const {
  std::string out;
  auto to = std::back_inserter(out);
  fmt::format_to(to, "# TYPE enfilade_requests_in_flight gauge\nenfilade_requests_in_flight {}\n",
                 in_flight_.load());
  for (const auto& [name, value] : gauges) {
    fmt::format_to(to, "# TYPE {} gauge\n{} {}\n", name, name, value);
  }
  const std::scoped_lock lock(mutex_);
  fmt::format_to(to, "# TYPE enfilade_requests_total counter\n");
  for (const auto& [key, count] : counts_) {
    fmt::format_to(to, "enfilade_requests_total{{route=\"{}\",status=\"{}\"}} {}\n", key.first,
                   key.second, count);
  }
  fmt::format_to(to, "# TYPE enfilade_request_seconds histogram\n");
  for (const auto& [route, times] : times_) {
    std::uint64_t below = 0;
    for (std::size_t k = 0; k < times.buckets.size(); ++k) {
      below += times.buckets[k];
      const std::string bound = k < kBounds.size() ? fmt::format("{}", kBounds[k]) : "+Inf";
      fmt::format_to(to, "enfilade_request_seconds_bucket{{route=\"{}\",le=\"{}\"}} {}\n", route,
                     bound, below);
    }
    fmt::format_to(to, "enfilade_request_seconds_sum{{route=\"{}\"}} {}\n", route, times.sum);
    fmt::format_to(to, "enfilade_request_seconds_count{{route=\"{}\"}} {}\n", route, below);
  }
  return out;
}

std::uint64_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::uint64_t pages = 0;
  statm >> pages >> pages;  // the second field
  return statm ? pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) : 0;
}

App::App(std::shared_ptr<const Site> site, ServerConfig config)
    : context_{std::move(site), std::move(config)},
      own_names_(context_.config.host, context_.config.public_names) {
  if (context_.config.warn) {
    for (const std::string& text : context_.submissions.ledger().warnings()) {
      context_.config.warn(text);
    }
  }
  const std::size_t most_bytes = context_.config.most_submission_bytes;
  add_browsing_routes(router_);
  add_session_routes(router_);
  add_evaluation_routes(router_, most_bytes);
  add_collection_routes(router_, most_bytes);
  add_operation_routes(router_);
}

// A page of another site whose name its owner has resolved to this machine may read all that this
// server says, as a page of the server's own. It can't change the name that the browser asks for.
void App::check_host(const Request& request) const {
  const std::string_view text = request.header("host");
  if (text.empty()) return;  // HTTP/1.0, of monitors; browsers always send it
  const auto host = net::parse_host(text);
  if (!host) throw HttpError(400, "Host: neither a name nor an address");
  if (own_names_.contains(*host)) return;
  throw HttpError(421, fmt::format("this server does not know that it is called {0}; if it is, "
                                   "start it with --public-name {0}",
                                   host->name));
}

// A page of another site can make a browser send its cookie, or log it in as another user. But it
// can neither send X-Enfilade nor keep the browser from sending the request's origin.
void App::check_origin(const Request& request) const {
  if (request.method == "GET") return;
  const std::string_view site = request.header("sec-fetch-site");  // other clients send none
  if (!site.empty() && site != "same-origin" && site != "none") {
    throw HttpError(403, "this page is of another site");
  }
  // Browsers send Sec-Fetch-Site over TLS and to localhost only, Origin always. That is "null" for
  // some requests of our own pages, as they hide their origin.
  const std::string_view origin = request.header("origin");
  const auto host = net::parse_host(request.header("host"));
  const bool own = (host && net::is_same_site(origin, *host)) || own_names_.is_given(origin) ||
                   (origin == "null" && site == "same-origin");
  if (!origin.empty() && !own) {
    throw HttpError(403, fmt::format("this page is of another site, {}; if it is this server's own "
                                     "name, start it with --public-name",
                                     origin.substr(0, 100)));
  }
  const bool by_cookie = request.principal && request.principal->by_cookie;
  if (by_cookie && request.header("x-enfilade").empty()) {
    throw HttpError(403, "requests with a cookie need the header X-Enfilade: 1");
  }
}

void App::identify(Request& request) {
  const std::string_view authorization = request.header("authorization");
  if (!authorization.empty()) {
    if (const std::string_view token = bearer_token(authorization); !token.empty()) {
      request.principal = accounts::find_token(context_.db, token);
    }
    if (!request.principal) {
      context_.failures.count(request.address, context_.db.now());
      throw HttpError(401, "the token is unknown, expired or revoked");
    }
    return;
  }
  const std::string_view cookie = cookie_of(request, session_cookie(request, context_.config));
  if (!cookie.empty()) {
    request.principal = accounts::find_session(context_.db, cookie);
  }
}

Response App::answer(Request& request, const BodyReader& read_body, std::string_view& pattern) {
  if (request.path.size() > kLongestPath) throw HttpError(414, "the path is too long");
  check_host(request);
  Router::Match match = router_.find(request.method, request.path);
  if (match.route == nullptr) {
    if (!match.methods.empty()) return wrong_method(std::move(match.methods));
    if (request.method == "GET") return page(context_, request);
    if (is_page(request.path)) return wrong_method({"GET"});
    throw HttpError(404, "there is nothing here");
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
  if (response.status == 401) response.add_header("WWW-Authenticate", "Bearer");
  if (!response.problem.empty()) {
    show_to_people(request, {context_.site->synthetic(), !context_.config.runs.empty()}, response);
  }
  compare_with_cached(request, response);
  compress(request, response);
  if (is_encrypted(request, context_.config)) {
    response.add_header("Strict-Transport-Security",
                        "max-age=31536000");  // a year, this host alone
  }
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

void App::count_refusal(const net::Request& request, const net::Response& response) {
  context_.metrics.count("(refused)", response.status, 0);
  if (!context_.config.log) return;
  RequestRecord record;
  record.address = request.address;
  record.method = request.method.empty() ? "-" : std::string_view(request.method);
  record.path = request.path;
  record.status = response.status;
  record.bytes = response.body->size();
  context_.config.log(record);
}

}  // namespace enfilade::service::http
