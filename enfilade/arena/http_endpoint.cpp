#include <fmt/format.h>
#include <httplib.h>
#include <algorithm>
#include <charconv>
#include <mutex>
#include <utility>
#include <vector>

#include "enfilade/arena/endpoint.h"

namespace enfilade::arena {
namespace {

constexpr double kLongest = 3600;
constexpr std::size_t kQuoted = 300;  // characters of what a server says, in a message

/// "http://host:port" and "/v1" of an address.
std::pair<std::string, std::string> parts_of(const std::string& url) {
  const std::size_t scheme = url.find("://");
  const std::string_view name = std::string_view(url).substr(0, scheme);
  if (scheme == std::string::npos || (name != "http" && name != "https")) {
    throw ArgumentError(fmt::format("endpoint: {:?}, not http://... or https://...", url));
  }
  const std::size_t path = std::min(url.find('/', scheme + 3), url.size());
  const std::string host = url.substr(0, path);
  if (host.size() <= scheme + 3 || url.find_first_of("@?# ") != std::string::npos) {
    // Keys in addresses end in logs.
    throw ArgumentError(
        "endpoint: an address without user, password, query and blanks is expected, "
        "like http://127.0.0.1:8000/v1; keys come from a file or the environment");
  }
  std::string prefix = url.substr(path);
  while (prefix.ends_with('/')) prefix.pop_back();
  return {host, prefix};
}

void check(const HttpEndpointConfig& config) {
  const auto printable = [](char c) { return c > ' ' && c < 127; };
  if (!std::ranges::all_of(config.key, printable)) {
    throw ArgumentError("key: it has characters that no key has: blanks, line ends, others");
  }
  if (!(config.timeout > 0 && config.timeout <= kLongest)) {
    throw ArgumentError(fmt::format("timeout: {} s, (0, {}]", config.timeout, kLongest));
  }
}

std::optional<double> seconds_of(const std::string& text) {
  double seconds = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seconds);
  if (error != std::errc() || end != text.data() + text.size() || !(seconds >= 0)) return {};
  return seconds;
}

class HttpEndpoint : public Endpoint {
 public:
  explicit HttpEndpoint(const HttpEndpointConfig& config) : config_(config) {
    check(config);
    std::tie(host_, prefix_) = parts_of(config.url);
  }

  std::string post(std::string_view body, const RequestOrigin& origin) override {
    const auto client = take();
    std::string calls;
    for (const Call& one : origin.calls) {
      calls += fmt::format("{}{} {}", calls.empty() ? "" : ";", one.tool, one.argument);
    }
    const httplib::Headers headers{{"X-Enfilade-Episode", origin.episode},
                                   {"X-Enfilade-Calls", calls}};
    const httplib::Result result =
        client->Post(prefix_ + "/chat/completions", headers, std::string(body), "application/json");
    if (!result) {
      throw EndpointError(0, fmt::format("{}: {}", host_, httplib::to_string(result.error())));
    }
    give_back(client);
    if (result->status == 200) return result->body;
    throw EndpointError(result->status,
                        hidden(fmt::format("{}: status {}: {}", host_, result->status,
                                           std::string_view(result->body).substr(0, kQuoted))),
                        seconds_of(result->get_header_value("Retry-After")));
  }

 private:
  using Client = std::shared_ptr<httplib::Client>;

  Client take() {
    {
      const std::scoped_lock lock(mutex_);
      if (!idle_.empty()) {
        Client client = std::move(idle_.back());
        idle_.pop_back();
        return client;
      }
    }
    auto client = std::make_shared<httplib::Client>(host_);
    const auto microseconds = static_cast<time_t>(config_.timeout * 1e6);
    client->set_keep_alive(true);
    client->set_read_timeout(microseconds / 1'000'000, microseconds % 1'000'000);
    client->set_write_timeout(microseconds / 1'000'000, microseconds % 1'000'000);
    client->set_tcp_nodelay(true);
    if (!config_.key.empty()) client->set_bearer_token_auth(config_.key);
    return client;
  }
  void give_back(Client client) {
    const std::scoped_lock lock(mutex_);
    idle_.push_back(std::move(client));
  }

  /// Servers may repeat the key in what they refuse.
  std::string hidden(std::string message) const {
    if (config_.key.empty()) return message;
    for (std::size_t at = message.find(config_.key); at != std::string::npos;
         at = message.find(config_.key)) {
      message.replace(at, config_.key.size(), "(key)");
    }
    return message;
  }

  HttpEndpointConfig config_;
  std::string host_, prefix_;
  std::mutex mutex_;
  std::vector<Client> idle_;
};

}  // namespace

std::unique_ptr<Endpoint> make_http_endpoint(const HttpEndpointConfig& config) {
  return std::make_unique<HttpEndpoint>(config);
}

}  // namespace enfilade::arena
