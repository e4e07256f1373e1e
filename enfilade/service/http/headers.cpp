#include "enfilade/service/http/headers.h"

#include <fmt/format.h>
#include <algorithm>

namespace enfilade::service::http {

std::string content_policy(std::string_view form_action, std::string_view frame_ancestors) {
  return fmt::format(
      "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
      "connect-src 'self'; font-src 'self'; base-uri 'none'; form-action {}; frame-ancestors {}",
      form_action, frame_ancestors);
}

void add_security_headers(Response& response) {
  const auto has = [&response](std::string_view name) {
    return std::ranges::any_of(response.headers,
                               [name](const auto& header) { return header.first == name; });
  };
  const auto add = [&](const char* name, std::string_view value) {
    if (!has(name)) response.headers.emplace_back(name, value);
  };
  static const std::string kContentPolicy = content_policy("'self'", "'none'");
  add("Content-Security-Policy", kContentPolicy);
  add("X-Content-Type-Options", "nosniff");
  if (!response.frameable) add("X-Frame-Options", "DENY");
  add("Referrer-Policy", "no-referrer");
  add("Cross-Origin-Opener-Policy", "same-origin");
  add("Cross-Origin-Resource-Policy", "same-origin");
  add("Permissions-Policy", "camera=(), microphone=(), geolocation=(), payment=()");
  // What is not said to be kept isn't: answers may depend on who asks.
  add("Cache-Control", "no-store");
}

}  // namespace enfilade::service::http
