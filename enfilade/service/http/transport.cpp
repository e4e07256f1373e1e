// The server: requests come by net::Server, and are answered by the App.
#include <algorithm>
#include <array>
#include <exception>
#include <mutex>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/net/server.h"
#include "enfilade/service/http/messages.h"
#include "enfilade/service/http/routes.h"

namespace enfilade::service {
namespace http {
namespace {

constexpr std::size_t kLeastRoom = 1U << 20U;  // for a body; what a worker submits
constexpr std::size_t kMediumBody = 1U << 20U;

/// Parsing takes several times a body's bytes, so one body is parsed at a time. There are two
/// kinds, so that workers need not wait while a results file is checked.
class Turns {
 public:
  /// Waits. \returns the turn, which ends with it
  std::unique_lock<std::mutex> wait(std::size_t bytes) {
    if (bytes <= net::kSmallBody) return {};
    return std::unique_lock(turns_[bytes > kMediumBody ? 1 : 0]);
  }

 private:
  std::array<std::mutex, 2> turns_;
};

Response refusal(const HttpError& error) {
  std::string fault;
  Response response = error_response(std::make_exception_ptr(error), fault);
  add_security_headers(response);
  return response;
}

}  // namespace
}  // namespace http

struct Server::Impl {
  http::App app;
  http::Turns turns;
  net::Server server;  // last: its threads use the others

  Impl(const std::shared_ptr<const Site>& site, const ServerConfig& config)
      : app(site, config), server(settings(config)) {}

  net::ServerConfig settings(const ServerConfig& config) {
    net::ServerConfig its;
    its.host = config.host;
    its.port = config.port;
    its.threads = config.threads;
    its.most_body_bytes = std::max(config.most_submission_bytes, http::kLeastRoom);
    its.body_seconds = config.body_seconds;
    its.behind_proxy = config.behind_proxy;
    its.refuse = [](const net::HttpError& error) { return http::refusal(error); };
    its.refused = [this](const net::Request& request, const net::Response& response) {
      app.count_refusal(request, response);
    };
    its.answer = [this](net::Request from, const net::BodyReader& read_body) -> net::Response {
      http::Request request;
      static_cast<net::Request&>(request) = std::move(from);
      request.query = http::parse_query(request.target);
      if (!read_body) return app.handle(std::move(request));
      std::unique_lock<std::mutex> turn;
      return app.handle(std::move(request), [this, &read_body, &turn](std::size_t most) {
        std::string body = read_body(most);
        turn = turns.wait(body.size());
        return body;
      });
    };
    return its;
  }
};

Server::Server(const std::shared_ptr<const Site>& site, const ServerConfig& config)
    : impl_(std::make_unique<Impl>(site, config)) {}

Server::~Server() { stop(); }

int Server::port() const noexcept { return impl_->server.port(); }

void Server::stop() { impl_->server.stop(); }

}  // namespace enfilade::service
