#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/arena/detail/bounded_client.h"
#include "enfilade/arena/detail/limits.h"
#include "enfilade/arena/detail/secrets.h"
#include "enfilade/arena/detail/texts.h"
#include "enfilade/arena/dialect.h"
#include "enfilade/arena/endpoint.h"
#include "enfilade/core/detail/json.h"
#include "enfilade/core/names.h"
#include "enfilade/core/numbers.h"
#include "enfilade/core/proxy.h"
#include "enfilade/core/written_lists.h"

namespace enfilade::arena {
namespace {

using detail::BoundedClient;
using detail::Host;
using detail::Response;
using detail::Secrets;

constexpr double kLongest = 3600;
constexpr std::size_t kMostBody = 4096;  // bytes of a refusal that are looked at, as the cache has

/// Host and "/v1/chat/completions?api-version=..." of an address.
struct Address {
  Host host;
  std::string origin;  // "https://model.invalid:8000"
  std::string target;
};

/// Names of a query's fields that have a key, which would end in logs.
bool is_secret(std::string_view name) {
  constexpr std::array<std::string_view, 9> kSecrets{"key",    "api_key", "api-key",
                                                     "apikey", "token",   "access_token",
                                                     "sig",    "code",    "subscription-key"};
  return std::ranges::any_of(kSecrets,
                             [name](std::string_view one) { return detail::is_same(name, one); });
}

bool has_secret(std::string_view query) {
  for (std::size_t at = 0; at < query.size();) {
    const std::size_t end = std::min(query.find('&', at), query.size());
    const std::string_view field = query.substr(at, end - at);
    if (is_secret(field.substr(0, field.find('=')))) return true;
    at = end + 1;
  }
  return false;
}

/// \param origin "https://model.invalid:8000"
Host host_of(const std::string& origin) {
  Host host;
  host.encrypted = origin.starts_with("https:");
  host.port = host.encrypted ? 443 : 80;
  const std::string_view rest = std::string_view(origin).substr(origin.find("://") + 3);
  const std::size_t end =
      rest.starts_with('[') ? rest.find(']') + 1 : std::min(rest.find(':'), rest.size());
  const std::string_view port = rest.substr(end);
  const auto number = port.starts_with(':') ? parse_number<std::uint16_t>(port.substr(1))
                                            : std::optional<std::uint16_t>();
  if (end == 0 || (!port.empty() && number.value_or(0) == 0)) {
    throw ArgumentError(
        fmt::format("endpoint: {}, not a host and a port from 1 to 65535", quote(rest)));
  }
  if (number) host.port = *number;
  host.name = rest.starts_with('[') ? rest.substr(1, end - 2) : rest.substr(0, end);
  return host;
}

Address address_of(const std::string& url) {
  constexpr std::string_view kEnd = "/chat/completions";
  const std::size_t scheme = url.find("://");
  const std::string_view name = std::string_view(url).substr(0, scheme);
  if (scheme == std::string::npos || (name != "http" && name != "https")) {
    const std::string shown = url.substr(url.rfind('@') + 1);  // npos + 1 is 0
    throw ArgumentError(fmt::format("endpoint: {:?}, not http://... or https://...",
                                    shown.substr(0, shown.find('?'))));
  }
  const std::size_t path = std::min(url.find_first_of("/?#", scheme + 3), url.size());
  const std::size_t query = std::min(url.find('?'), url.size());
  const std::string host = url.substr(0, path);
  if (host.size() <= scheme + 3 || url.find_first_of("@# ") != std::string::npos ||
      has_secret(std::string_view(url).substr(std::min(query + 1, url.size())))) {
    // Keys in addresses end in logs.
    throw ArgumentError(
        "endpoint: an address without user, password, key and blanks is expected, "
        "like http://127.0.0.1:8000/v1; keys come from a file or the environment");
  }
  std::string prefix = url.substr(path, query - path);
  while (prefix.ends_with('/')) prefix.pop_back();
  if (!prefix.ends_with(kEnd)) prefix += kEnd;
  return {host_of(host), host, prefix + url.substr(query)};
}

bool is_header_value(std::string_view text) {
  return std::ranges::all_of(text, [](char c) { return c >= ' ' && c < 127; });
}

void check(const HttpEndpointConfig& config) {
  const auto printable = [](char c) { return c > ' ' && c < 127; };
  if (!std::ranges::all_of(config.key, printable)) {
    throw ArgumentError("key: it has characters that no key has: blanks, line ends, others");
  }
  const auto in_name = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_';
  };
  const auto check_name = [&in_name](const std::string& name) {
    if (std::ranges::all_of(name, in_name)) return;
    throw ArgumentError("headers: a name has other characters than letters, digits, - and _");
  };
  check_name(config.key_header);
  for (const auto& [name, value] : config.headers) {
    check_name(name);
    if (!is_header_value(value)) {
      throw ArgumentError(fmt::format("headers: {} has characters that are not ASCII", name));
    }
  }
  if (!(config.timeout > 0 && config.timeout <= kLongest)) {
    throw ArgumentError(fmt::format("timeout: {} s, (0, {}]", config.timeout, kLongest));
  }
}

/// Of `Retry-After`; a date is ignored.
std::optional<double> seconds_of(const std::string& text) {
  const auto seconds = parse_number<double>(text);
  return seconds && std::isfinite(*seconds) && *seconds >= 0 ? seconds : std::nullopt;
}

/// The headers that each request has.
BoundedClient::Headers headers_of(const HttpEndpointConfig& config) {
  BoundedClient::Headers headers = config.headers;
  const auto has = [&headers](std::string_view name) {
    return std::ranges::any_of(
        headers, [name](const auto& one) { return detail::is_same(one.first, name); });
  };
  const bool bearer = config.key_header.empty();
  const std::string key_header = bearer ? "Authorization" : config.key_header;
  if (!config.key.empty() && !has(key_header)) {
    headers.emplace_back(key_header, bearer ? "Bearer " + config.key : config.key);
  }
  headers.emplace_back("Content-Type", "application/json");
  return headers;
}

/// Whether a header's name says that its value is a secret.
bool is_login(std::string_view name) {
  constexpr std::array<std::string_view, 6> kParts{"auth",  "cookie", "key",
                                                   "login", "secret", "token"};
  return std::ranges::any_of(kParts, [name](std::string_view part) {
    return !std::ranges::search(name, part, [](char one, char other) {
              return std::tolower(static_cast<unsigned char>(one)) == other;
            }).empty();
  });
}

/// What no server may bring into a file: the key, the values of headers, and the proxy's login. A
/// short value of another header, as "1", is no secret, and would be in many answers.
Secrets secrets_of(const HttpEndpointConfig& config, const std::optional<Proxy>& proxy) {
  std::vector<std::string> secrets{config.key};
  for (const auto& [name, value] : config.headers) {
    const bool short_too = is_login(name) || detail::is_same(name, config.key_header);
    const auto add = [&](std::string_view one) {
      if (short_too || one.size() >= Secrets::kLeastPart) secrets.emplace_back(one);
    };
    add(value);
    const std::size_t blank = value.find(' ');  // "Bearer KEY"
    if (blank != std::string::npos) add(trimmed(std::string_view(value).substr(blank)));
  }
  if (proxy) {
    secrets.push_back(proxy->password);
    secrets.push_back(proxy->password.empty() ? "" : proxy->user + ":" + proxy->password);
  }
  return Secrets(secrets);
}

class HttpEndpoint : public Endpoint {
 public:
  explicit HttpEndpoint(const HttpEndpointConfig& config) : timeout_(config.timeout) {
    check(config);
    address_ = address_of(config.url);
    proxy_ = proxy_for(address_.origin);
    shown_ = address_.origin;
    if (proxy_) {
      shown_ += fmt::format(" through the proxy {} ({})", proxy_->address(), proxy_->variable);
    }
    headers_ = headers_of(config);
    secrets_ = secrets_of(config, proxy_);
  }

  std::string post(std::string_view body, const RequestOrigin& origin) override {
    BoundedClient::Headers headers = headers_;
    std::string calls;
    for (const Call& one : origin.calls) {
      calls += fmt::format("{}{} {}", calls.empty() ? "" : ";", one.tool, one.argument);
    }
    for (const auto& [name, value] :
         {std::pair{"X-Enfilade-Episode", std::string_view(origin.episode)},
          std::pair{"X-Enfilade-Calls", std::string_view(calls)}}) {
      if (!is_header_value(value)) {
        throw ArgumentError(fmt::format("{}: {}, not of printable ASCII", name, quote(value)));
      }
      headers.emplace_back(name, value);
    }
    Client client = take();
    const Response response = exchange(*client, headers, body);
    give_back(std::move(client));
    return answer_in(response);
  }

 private:
  using Client = std::unique_ptr<BoundedClient>;

  /// \throws EndpointError
  Response exchange(BoundedClient& client, const BoundedClient::Headers& headers,
                    std::string_view body) const {
    try {
      return client.post(address_.target, headers, body);
    } catch (const EndpointError& error) {
      throw EndpointError(0, fmt::format("{}: {}", shown_, words_in(secrets_.hide(error.what()))));
    }
  }

  /// \throws EndpointError for a refusal, and for an answer over the limits
  std::string answer_in(const Response& response) const {
    std::string answer = response.body;
    if (response.status == 200) {
      const bool parts =
          response.type.starts_with("text/event-stream") ||
          trimmed(std::string_view(answer).substr(0, kMostBody)).starts_with("data:");
      if (parts) answer = join_events(answer);
    }
    const std::string found = json::excess(answer, detail::kAnswerLimits);
    if (response.status == 200) {
      if (found.empty()) return secrets_.hide_in_body(std::move(answer));
      throw EndpointError(0, fmt::format("{}: an answer of {}", shown_, found));
    }
    answer = found.empty() ? secrets_.hide_in_body(std::move(answer)) : secrets_.hide(answer);
    const std::string refusal = answer.substr(0, kMostBody);
    const std::string message =
        fmt::format("{}: status {}: {}", shown_, response.status, words_in(refusal));
    throw EndpointError(response.status, message, seconds_of(response.retry_after), refusal);
  }

  Client take() {
    const std::scoped_lock lock(mutex_);
    if (idle_.empty()) return std::make_unique<BoundedClient>(address_.host, proxy_, timeout_);
    Client client = std::move(idle_.back());
    idle_.pop_back();
    return client;
  }
  void give_back(Client client) {
    const std::scoped_lock lock(mutex_);
    idle_.push_back(std::move(client));
  }

  double timeout_;
  Address address_;
  std::optional<Proxy> proxy_;
  std::string shown_;               // the host, and the proxy
  BoundedClient::Headers headers_;  // of each request
  Secrets secrets_;
  std::mutex mutex_;
  std::vector<Client> idle_;
};

}  // namespace

std::unique_ptr<Endpoint> make_http_endpoint(const HttpEndpointConfig& config) {
  return std::make_unique<HttpEndpoint>(config);
}

}  // namespace enfilade::arena
