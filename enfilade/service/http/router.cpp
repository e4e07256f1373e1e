#include "enfilade/service/http/router.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <ranges>

namespace enfilade::service::http {
namespace {

using accounts::Role;

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

bool may_call(Access access, Role role) {
  return (access == Access::kTeam && role == Role::kTeam) ||
         (access == Access::kOrganiser && role == Role::kOrganiser) ||
         (access == Access::kReviewer && (role == Role::kOrganiser || role == Role::kReviewer)) ||
         (access == Access::kWorker && role == Role::kWorker);
}

std::string_view audience(Access access) {
  constexpr std::array<std::string_view, 5> kNames{"everybody", "a team", "an organiser",
                                                   "a reviewer or an organiser", "a worker"};
  return kNames[static_cast<std::size_t>(access)];
}

}  // namespace

void check_access(const Route& route, const Request& request) {
  if (route.access == Access::kPublic) return;
  if (!may_call(route.access, request.known_principal().role)) {
    throw HttpError(403, fmt::format("this is for {}", audience(route.access)));
  }
}

Router::Match Router::find(std::string_view method, std::string_view path) const {
  Match match;
  const std::vector<std::string_view> parts = split_path(path);
  for (const Route& route : routes_) {
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

}  // namespace enfilade::service::http
