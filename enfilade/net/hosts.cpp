#include "enfilade/net/hosts.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/numbers.h"
#include "enfilade/core/texts.h"

namespace enfilade::net {
namespace {

constexpr std::size_t kLongestHost = 253;  // of DNS

bool is_literal(int family, const std::string& text) {
  std::array<unsigned char, sizeof(in6_addr)> ignored{};
  return ::inet_pton(family, text.c_str(), ignored.data()) == 1;
}

bool is_bracketed(std::string_view name) { return name.starts_with('[') && name.ends_with(']'); }

bool is_dns_name(std::string_view text) {
  return !text.empty() && text.size() <= kLongestHost && std::ranges::all_of(text, [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' || c == '_';
  });
}

struct Origin {
  Host host;
  std::string_view usual_port;
};

std::optional<Origin> parse_origin(std::string_view text) {
  for (const auto& [scheme, port] :
       {std::pair<std::string_view, std::string_view>{"http://", "80"}, {"https://", "443"}}) {
    if (!text.starts_with(scheme)) continue;
    auto host = parse_host(text.substr(scheme.size()));
    if (!host) return std::nullopt;
    return Origin{std::move(*host), port};
  }
  return std::nullopt;  // "null", of a page that must not say where it is from
}

std::string machine_name() {
  std::array<char, kLongestHost + 1> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) return {};
  const auto host = parse_host(name.data());
  return host ? host->name : std::string();
}

bool is_this_machine_only(const std::string& interface) {
  return interface == "localhost" || interface.starts_with("127.") || interface == "::1";
}

}  // namespace

std::optional<Host> parse_host(std::string_view text) {
  Host host;
  // In an IPv6 address there are more colons; it has brackets around it.
  const std::size_t colon = text.rfind(':');
  if (colon != std::string_view::npos && !text.ends_with(']')) {
    host.port = text.substr(colon + 1);
    text = text.substr(0, colon);
    if (!host.port.empty() && !parse_number<std::uint16_t>(host.port)) return std::nullopt;
  }
  if (is_bracketed(text)) {
    if (!is_literal(AF_INET6, std::string(text.substr(1, text.size() - 2)))) return std::nullopt;
  } else {
    if (text.ends_with('.')) text.remove_suffix(1);
    if (!is_dns_name(text) || text.ends_with('.')) return std::nullopt;
  }
  host.name = lower_case(text);
  return host;
}

bool is_same_site(std::string_view origin, const Host& host) {
  const auto page = parse_origin(origin);
  if (!page || page->host.name != host.name) return false;
  const auto port = [&page](const Host& of) {
    return of.port.empty() ? page->usual_port : std::string_view(of.port);
  };
  return port(page->host) == port(host);
}

OwnNames::OwnNames(const std::string& interface, const std::vector<std::string>& given) {
  for (const std::string& text : given) {
    const auto host = parse_host(text);
    if (!host || !host->port.empty()) {
      throw ArgumentError(fmt::format(
          "public name: {:?}, not a name like vln.example.org, without http:// and port",
          text.substr(0, kLongestHost)));
    }
    given_.insert(host->name);
  }
  if (is_this_machine_only(interface)) return;
  if (const auto host = parse_host(interface)) machine_.insert(host->name);
  if (const std::string name = machine_name(); !name.empty()) {
    machine_.insert(name);
    const std::string first = name.substr(0, name.find('.'));
    machine_.insert({first, first + ".local"});
  }
}

bool OwnNames::contains(const Host& host) const {
  return is_bracketed(host.name) || is_literal(AF_INET, host.name) || host.name == "localhost" ||
         given_.contains(host.name) || machine_.contains(host.name);
}

bool OwnNames::is_given(std::string_view origin) const {
  const auto page = parse_origin(origin);
  return page && given_.contains(page->host.name);
}

std::optional<std::string> parse_address(std::string_view entry) {
  constexpr std::string_view kAround = " \t\"";
  entry.remove_prefix(std::min(entry.find_first_not_of(kAround), entry.size()));
  entry = entry.substr(0, entry.find_last_not_of(kAround) + 1);  // npos + 1 is 0
  const auto is_port = [](std::string_view text) {
    return text.starts_with(':') && parse_number<std::uint16_t>(text.substr(1)).has_value();
  };
  const auto address = [](std::string_view text) -> std::optional<std::string> {
    std::string literal(text.substr(0, text.find('%')));
    if (literal.find('\0') != std::string::npos) return std::nullopt;
    const bool has_zone = literal.size() < text.size();  // which IPv4 has not
    const bool is_one =
        is_literal(AF_INET6, literal) || (!has_zone && is_literal(AF_INET, literal));
    return is_one ? std::optional(std::move(literal)) : std::nullopt;
  };
  if (entry.starts_with('[')) {
    const std::size_t end = std::min(entry.find(']'), entry.size() - 1);
    const std::string_view rest = entry.substr(end + 1), inner = entry.substr(1, end - 1);
    if (entry[end] != ']' || inner.find(':') == std::string_view::npos) return std::nullopt;
    return rest.empty() || is_port(rest) ? address(inner) : std::nullopt;
  }
  if (auto whole = address(entry)) return whole;
  // "2001:db8::1:51234" without brackets: five digits are no part of an address. Four could be one,
  // but then of the part that a group of addresses leaves out.
  const std::size_t colon = std::min(entry.rfind(':'), entry.size());
  return is_port(entry.substr(colon)) ? address(entry.substr(0, colon)) : std::nullopt;
}

std::string address_group(std::string_view address) {
  std::string text = parse_address(address).value_or(std::string(address));
  in6_addr bytes{};
  if (inet_pton(AF_INET6, text.c_str(), &bytes) != 1) return text;
  std::array<char, INET6_ADDRSTRLEN> written{};
  if (IN6_IS_ADDR_V4MAPPED(&bytes)) {
    inet_ntop(AF_INET, &bytes.s6_addr[12], written.data(), written.size());
    return written.data();
  }
  std::fill(std::begin(bytes.s6_addr) + 8, std::end(bytes.s6_addr), std::uint8_t{0});
  inet_ntop(AF_INET6, &bytes, written.data(), written.size());
  return std::string(written.data()) + "/64";
}

}  // namespace enfilade::net
