#include <fmt/format.h>
#include <httplib.h>
#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/arena/detail/texts.h"
#include "enfilade/arena/dialect.h"
#include "enfilade/arena/endpoint.h"
#include "enfilade/core/detail/json.h"
#include "enfilade/core/numbers.h"
#include "enfilade/core/proxy.h"
#include "enfilade/core/written_lists.h"

namespace enfilade::arena {
namespace {

constexpr double kLongest = 3600;
constexpr std::size_t kMostAnswer = 1 << 24;  // bytes; pages of reasoning are a hundredth of it
// A token of a stream is an event of some twenty values.
constexpr json::Limits kAnswerLimits{.values = 2'000'000, .depth = 64};
constexpr std::size_t kMostBody = 4096;  // bytes of a refusal that are looked at, as the cache has

/// "http://host:port" and "/v1/chat/completions?api-version=..." of an address.
struct Address {
  std::string host, target;
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
  return {host, prefix + url.substr(query)};
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
    if (!std::ranges::all_of(value, [](char c) { return c >= ' ' && c < 127; })) {
      throw ArgumentError(fmt::format("headers: {} has characters that are not ASCII", name));
    }
  }
  if (!(config.timeout > 0 && config.timeout <= kLongest)) {
    throw ArgumentError(fmt::format("timeout: {} s, (0, {}]", config.timeout, kLongest));
  }
}

std::optional<double> seconds_of(const std::string& text) {
  const auto seconds = parse_number<double>(text);
  return seconds && *seconds >= 0 ? seconds : std::nullopt;
}

class HttpEndpoint : public Endpoint {
 public:
  explicit HttpEndpoint(const HttpEndpointConfig& config) : config_(config) {
    check(config);
    address_ = address_of(config.url);
    proxy_ = proxy_for(address_.host);
    shown_ = address_.host;
    if (proxy_) {
      shown_ += fmt::format(" through the proxy {} ({})", proxy_->address(), proxy_->variable);
    }
  }

  std::string post(std::string_view body, const RequestOrigin& origin) override {
    const auto client = take();
    std::string calls;
    for (const Call& one : origin.calls) {
      calls += fmt::format("{}{} {}", calls.empty() ? "" : ";", one.tool, one.argument);
    }
    httplib::Headers headers{{"X-Enfilade-Episode", origin.episode}, {"X-Enfilade-Calls", calls}};
    for (const auto& [name, value] : config_.headers) headers.emplace(name, value);
    const bool bearer = config_.key_header.empty();
    const std::string key_header = bearer ? "Authorization" : config_.key_header;
    if (!config_.key.empty() && !headers.contains(key_header)) {
      headers.emplace(key_header, bearer ? "Bearer " + config_.key : config_.key);
    }
    // The library sends the proxy's login to the server, too, unless this header is there.
    if (proxy_ && !proxy_->user.empty() && address_.host.starts_with("https://")) {
      headers.emplace("Proxy-Authorization", "");
    }
    headers.emplace("Content-Type", "application/json");
    std::string answer;
    const httplib::Result result = send(*client, std::move(headers), body, answer);
    give_back(client);
    if (result->status == 200) {
      if (const std::string found = json::excess(answer, kAnswerLimits); !found.empty()) {
        throw EndpointError(0, fmt::format("{}: an answer of {}", shown_, found));
      }
      const bool parts =
          result->get_header_value("Content-Type").starts_with("text/event-stream") ||
          trimmed(std::string_view(answer).substr(0, kMostBody)).starts_with("data:");
      if (parts) answer = join_events(answer);
      // What is no answer is an error, which is shown.
      return answer.find("\"choices\"") == std::string::npos ? hidden(std::move(answer)) : answer;
    }
    const std::string refusal = hidden(std::move(answer)).substr(0, kMostBody);
    const std::string message =
        fmt::format("{}: status {}: {}", shown_, result->status, words_in(refusal));
    throw EndpointError(result->status, message,
                        seconds_of(result->get_header_value("Retry-After")), refusal);
  }

 private:
  using Client = std::shared_ptr<httplib::Client>;

  /// \param answer  its body. \throws EndpointError if there is none, or no end of it
  httplib::Result send(httplib::Client& client, httplib::Headers headers, std::string_view body,
                       std::string& answer) const {
    using Clock = std::chrono::steady_clock;
    const auto latest = Clock::now() + std::chrono::duration<double>(config_.timeout);
    httplib::Request request;
    request.method = "POST";
    request.path = address_.target;
    request.headers = std::move(headers);
    request.body = body;
    request.content_receiver = [&](const char* data, std::size_t size, std::uint64_t,
                                   std::uint64_t) {
      answer.append(data, size);
      return answer.size() <= kMostAnswer && Clock::now() <= latest;
    };
    httplib::Result result = client.send(request);
    if (result) return result;
    const std::string why =
        answer.size() > kMostAnswer ? fmt::format("more than {} MiB", kMostAnswer >> 20)
        : Clock::now() > latest     ? fmt::format("no whole answer in {} s", config_.timeout)
                                    : httplib::to_string(result.error());
    throw EndpointError(0, fmt::format("{}: {}", shown_, why));
  }

  Client take() {
    {
      const std::scoped_lock lock(mutex_);
      if (!idle_.empty()) {
        Client client = std::move(idle_.back());
        idle_.pop_back();
        return client;
      }
    }
    auto client = std::make_shared<httplib::Client>(address_.host);
    const auto microseconds = static_cast<time_t>(config_.timeout * 1e6);
    client->set_keep_alive(true);
    client->set_read_timeout(microseconds / 1'000'000, microseconds % 1'000'000);
    client->set_write_timeout(microseconds / 1'000'000, microseconds % 1'000'000);
    client->set_tcp_nodelay(true);
    if (proxy_) {
      client->set_proxy(proxy_->host, proxy_->port);
      if (!proxy_->user.empty()) client->set_proxy_basic_auth(proxy_->user, proxy_->password);
    }
    return client;
  }
  void give_back(Client client) {
    const std::scoped_lock lock(mutex_);
    idle_.push_back(std::move(client));
  }

  /// Servers may repeat the key, and other headers, in what they refuse.
  std::string hidden(std::string message) const {
    constexpr std::size_t kShortest = 6;  // shorter ones are words of other texts
    std::vector<std::string_view> secrets;
    if (config_.key.size() >= kShortest) secrets.push_back(config_.key);
    for (const auto& [name, value] : config_.headers) {
      if (value.size() >= kShortest) secrets.push_back(value);
      const std::size_t blank = value.find(' ');  // "Bearer KEY"
      if (blank != std::string::npos && value.size() - blank > kShortest) {
        secrets.push_back(std::string_view(value).substr(blank + 1));
      }
    }
    for (const std::string_view secret : secrets) {
      for (std::size_t at = message.find(secret); at != std::string::npos;
           at = message.find(secret, at)) {
        message.replace(at, secret.size(), "(key)");
        at += 5;
      }
    }
    return message;
  }

  HttpEndpointConfig config_;
  Address address_;
  std::optional<Proxy> proxy_;
  std::string shown_;  // the host, and the proxy
  std::mutex mutex_;
  std::vector<Client> idle_;
};

}  // namespace

std::unique_ptr<Endpoint> make_http_endpoint(const HttpEndpointConfig& config) {
  return std::make_unique<HttpEndpoint>(config);
}

}  // namespace enfilade::arena
