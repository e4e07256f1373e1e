#include "enfilade/service/http/http.h"

#include <fmt/format.h>
#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "enfilade/core/check.h"

namespace enfilade::service::http {
namespace {

constexpr std::size_t kMostDiagnostics = 200;

bool is_placeholder(std::string_view part) {
  return part.size() > 2 && part.front() == '{' && part.back() == '}';
}

}  // namespace

std::string_view Request::header(std::string_view name) const {
  const auto found = headers.find(name);
  return found == headers.end() ? std::string_view{} : std::string_view(found->second);
}

const std::string& Request::parameter(std::string_view name) const {
  const auto found = parameters.find(name);
  EN_CHECK(found != parameters.end());
  return found->second;
}

std::string Request::text(std::string_view name) const {
  const auto found = query.find(name);
  return found == query.end() ? std::string{} : found->second;
}

std::int64_t Request::number(std::string_view name, std::int64_t otherwise, std::int64_t least,
                             std::int64_t most) const {
  const auto found = query.find(name);
  if (found == query.end()) return otherwise;
  const std::string& text = found->second;
  const auto value = parse_number(text);
  if (!value || *value < least || *value > most) {
    throw HttpError(400, "bad-query",
                    fmt::format("{}: {:?}, not a whole number from {} to {}", name,
                                text.substr(0, 40), least, most));
  }
  return *value;
}

Response json_response(std::string json, int status) {
  Response response;
  response.status = status;
  response.body = std::make_shared<const std::string>(std::move(json));
  return response;
}

Response csv_response(std::string csv) {
  Response response = json_response(std::move(csv));
  response.type = "text/csv; charset=utf-8";
  return response;
}

Response error_response(int status, std::string_view code, std::string_view message,
                        const std::vector<Diagnostic>& diagnostics) {
  nlohmann::ordered_json error{{"code", code}, {"message", message}};
  if (!diagnostics.empty()) {
    auto& list = error["diagnostics"] = nlohmann::ordered_json::array();
    for (const Diagnostic& d : diagnostics) {
      if (list.size() == kMostDiagnostics) break;
      list.push_back({{"severity", to_string(d.severity)},
                      {"where", d.where},
                      {"code", d.code},
                      {"message", d.message}});
    }
    error["diagnostic_count"] = diagnostics.size();
  }
  // A message may quote bytes of the request, which need not be UTF-8.
  return json_response(nlohmann::ordered_json{{"error", error}}.dump(
                           -1, ' ', false, nlohmann::ordered_json::error_handler_t::replace),
                       status);
}

std::optional<std::int64_t> parse_number(std::string_view text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::vector<std::string_view> split_path(std::string_view path) {
  std::vector<std::string_view> parts;
  if (path.starts_with('/')) path.remove_prefix(1);
  while (true) {
    const std::size_t slash = path.find('/');
    parts.push_back(path.substr(0, slash));
    if (slash == std::string_view::npos) return parts;
    path.remove_prefix(slash + 1);
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
      match.other_method = true;
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
