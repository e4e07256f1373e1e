#include "enfilade/core/proxy.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/numbers.h"
#include "enfilade/core/texts.h"

namespace enfilade {
namespace {

/// A host and the text after its colon; brackets of IPv6 addresses are taken off.
struct HostPort {
  std::string host, port;
};
HostPort split_host(std::string_view text) {
  if (text.starts_with('[')) {
    const std::size_t end = std::min(text.find(']'), text.size());
    const std::string_view rest = text.substr(std::min(end + 1, text.size()));
    return {lower_case(text.substr(1, end - 1)),
            std::string(rest.starts_with(':') ? rest.substr(1) : std::string_view())};
  }
  const std::size_t colon = text.find(':');
  // More than one colon: an IPv6 address without brackets.
  if (colon == std::string_view::npos || text.find(':', colon + 1) != std::string_view::npos) {
    return {lower_case(text), {}};
  }
  return {lower_case(text.substr(0, colon)), std::string(text.substr(colon + 1))};
}

/// The scheme and the host of an address, with its port or the scheme's.
struct Target {
  std::string scheme, host, port;
};
Target target_of(std::string_view url) {
  Target target;
  const std::size_t scheme = url.find("://");
  if (scheme != std::string_view::npos) {
    target.scheme = lower_case(url.substr(0, scheme));
    url.remove_prefix(scheme + 3);
  }
  url = url.substr(0, url.find_first_of("/?#"));
  if (const std::size_t at = url.rfind('@'); at != std::string_view::npos)
    url.remove_prefix(at + 1);
  HostPort parts = split_host(url);
  while (parts.host.ends_with('.')) parts.host.pop_back();
  target.host = std::move(parts.host);
  target.port = !parts.port.empty() ? parts.port : target.scheme == "https" ? "443" : "80";
  return target;
}

std::optional<std::uint32_t> ipv4_of(const std::string& host) {
  in_addr address{};
  if (inet_pton(AF_INET, host.c_str(), &address) != 1) return std::nullopt;
  return ntohl(address.s_addr);
}

bool is_own_machine(const std::string& host) {
  if (host == "localhost" || host.ends_with(".localhost") || host == "::1") return true;
  const auto address = ipv4_of(host);
  return address && *address >> 24U == 127;
}

/// Whether an address lies in "10.0.0.0/8".
bool is_in_range(const std::string& host, std::string_view range) {
  const std::size_t slash = range.find('/');
  if (slash == std::string_view::npos) return false;
  const auto bits = parse_number<unsigned>(range.substr(slash + 1));
  const auto first = ipv4_of(std::string(range.substr(0, slash))), address = ipv4_of(host);
  if (!bits || *bits > 32 || !first || !address) return false;
  return *bits == 0 || (*first ^ *address) >> (32 - *bits) == 0;
}

bool is_excepted(const Target& target, std::string_view entry) {
  if (entry == "*" || is_in_range(target.host, entry)) return true;
  auto [host, port] = split_host(entry);
  if (!port.empty() && port != target.port) return false;
  if (host.starts_with("*.")) host.erase(0, 1);
  while (host.starts_with('.')) host.erase(0, 1);
  while (host.ends_with('.')) host.pop_back();
  if (host.empty() || !target.host.ends_with(host)) return false;
  return target.host.size() == host.size() ||
         target.host[target.host.size() - host.size() - 1] == '.';
}

bool is_excepted_by(const Target& target, std::string_view list) {
  constexpr std::string_view kBetween = ", \t";
  for (std::size_t at = 0; at < list.size();) {
    const std::size_t end = std::min(list.find_first_of(kBetween, at), list.size());
    if (end > at && is_excepted(target, list.substr(at, end - at))) return true;
    at = end + 1;
  }
  return false;
}

Proxy parse_proxy(std::string_view text, const std::string& variable) {
  const auto refuse = [&variable](const char* why) {
    throw ArgumentError(fmt::format("{}: {}; http://HOST:PORT is expected", variable, why));
  };
  if (const std::size_t scheme = text.find("://"); scheme != std::string_view::npos) {
    if (lower_case(text.substr(0, scheme)) != "http") refuse("a proxy of another kind than HTTP");
    text.remove_prefix(scheme + 3);
  }
  text = text.substr(0, text.find_first_of("/?#"));
  Proxy proxy;
  proxy.variable = variable;
  if (const std::size_t at = text.rfind('@'); at != std::string_view::npos) {
    const std::string_view name = text.substr(0, at);
    const std::size_t colon = std::min(name.find(':'), name.size());
    proxy.user = decode_percent(name.substr(0, colon));
    proxy.password = decode_percent(name.substr(std::min(colon + 1, name.size())));
    text.remove_prefix(at + 1);
  }
  const auto [host, port] = split_host(text);
  if (host.empty()) refuse("no host");
  proxy.host = host;
  if (!port.empty()) {
    const auto number = parse_number<int>(port);
    if (!number || *number < 1 || *number > 65535) refuse("the port is not 1 to 65535");
    proxy.port = number.value_or(0);
  }
  return proxy;
}

}  // namespace

std::string Proxy::address() const {
  const bool is_ipv6 = host.find(':') != std::string::npos;
  return fmt::format("{}:{}", is_ipv6 ? "[" + host + "]" : host, port);
}

std::optional<Proxy> proxy_for(std::string_view url) {
  return proxy_for(url, [](const char* name) { return std::getenv(name); });
}

std::optional<Proxy> proxy_for(std::string_view url, const Environment& environment) {
  const auto value_of = [&environment](const char* name) {
    const char* const value = environment(name);
    return value == nullptr ? std::string() : std::string(value);
  };
  const Target target = target_of(url);
  if (is_own_machine(target.host)) return std::nullopt;
  const bool secure = target.scheme == "https";
  const std::array<const char*, 4> variables{secure ? "https_proxy" : "http_proxy",
                                             secure ? "HTTPS_PROXY" : "HTTP_PROXY", "all_proxy",
                                             "ALL_PROXY"};
  const auto named = std::ranges::find_if(
      variables, [&value_of](const char* name) { return !value_of(name).empty(); });
  if (named == variables.end()) return std::nullopt;
  std::string excepted = value_of("no_proxy");
  if (excepted.empty()) excepted = value_of("NO_PROXY");
  if (is_excepted_by(target, excepted)) return std::nullopt;
  return parse_proxy(value_of(*named), *named);
}

}  // namespace enfilade
