#include "enfilade/service/http/headers.h"

#include <fmt/format.h>

#include "enfilade/core/gzip.h"
#include "enfilade/service/detail/hosts.h"

namespace enfilade::service::http {
namespace {

constexpr std::size_t kWorthCompressing = 1024;  // bytes; of less, the headers are the larger part

// Pictures are compressed already.
bool is_worth_compressing(std::string_view type) {
  return type.starts_with("text/") || type.starts_with("application/json") ||
         type.starts_with("image/svg") || type == "application/octet-stream";
}

}  // namespace

bool accepts_gzip(const Request& request) {
  const std::string_view accepted = request.header("accept-encoding");
  return accepted.find("gzip") != std::string_view::npos &&
         accepted.find("gzip;q=0") == std::string_view::npos;
}

void compress(const Request& request, Response& response) {
  if (!is_worth_compressing(response.type) || response.body->size() < kWorthCompressing) return;
  if (response.header("Content-Encoding")) return;
  response.add_header("Vary", "Accept-Encoding");
  if (!accepts_gzip(request)) return;
  response.body = std::make_shared<const std::string>(gzip(*response.body, 5));
  response.add_header("Content-Encoding", "gzip");
}

void compare_with_cached(const Request& request, Response& response) {
  const std::string_view known = request.header("if-none-match");
  const auto tag = response.header("ETag");
  if (response.status != 200 || !tag || known.find(*tag) == std::string_view::npos) return;
  response.status = 304;
  response.body = std::make_shared<const std::string>();
}

bool is_encrypted(const Request& request, const ServerConfig& config) {
  return config.behind_proxy && request.header("x-forwarded-proto") == "https";
}

std::string session_cookie(const Request& request, const ServerConfig& config) {
  const auto host = detail::parse_host(request.header("host"));
  const bool with_port = host && !host->port.empty();
  return fmt::format("{}{}{}{}", is_encrypted(request, config) ? "__Host-" : "",
                     accounts::kSessionCookie, with_port ? "_" : "", with_port ? host->port : "");
}

std::string content_policy(std::string_view form_action, std::string_view frame_ancestors) {
  return fmt::format(
      "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
      "connect-src 'self'; font-src 'self'; base-uri 'none'; form-action {}; frame-ancestors {}",
      form_action, frame_ancestors);
}

void add_security_headers(Response& response) {
  const auto add = [&response](const char* name, std::string_view value) {
    if (!response.header(name)) response.add_header(name, std::string(value));
  };
  static const std::string kContentPolicy = content_policy("'self'", "'none'");
  add("Content-Security-Policy", kContentPolicy);
  add("X-Content-Type-Options", "nosniff");
  if (!response.frameable) add("X-Frame-Options", "DENY");
  add("Referrer-Policy", "no-referrer");
  add("Cross-Origin-Opener-Policy", "same-origin");
  add("Cross-Origin-Resource-Policy", "same-origin");
  add("Permissions-Policy", "camera=(), microphone=(), geolocation=(), payment=()");
  // Responses may depend on the client: none is cached unless its route says so.
  add("Cache-Control", "no-store");
}

}  // namespace enfilade::service::http
