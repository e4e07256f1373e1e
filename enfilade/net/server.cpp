#include "enfilade/net/server.h"

#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "enfilade/core/mapped_file.h"
#include "enfilade/net/connections/body.h"
#include "enfilade/net/connections/lobby.h"
#include "enfilade/net/connections/response_text.h"

namespace enfilade::net {
namespace {

using connections::Guest;
using connections::Lobby;

constexpr int kQueue = 511;          // of connections that are not accepted yet, as nginx has it
constexpr int kMostRequests = 1000;  // of a connection
constexpr std::size_t kOnePacket = 16U << 10U;  // of a response that is sent in one go

/// A socket that listens, or -1.
int listen_on(const addrinfo& address) {
  const int one = ::socket(address.ai_family, address.ai_socktype | SOCK_CLOEXEC | SOCK_NONBLOCK,
                           address.ai_protocol);
  if (one < 0) return -1;
  const int on = 1, off = 0;
  // Not SO_REUSEPORT, which would let two servers share a port and its requests.
  ::setsockopt(one, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (address.ai_family == AF_INET6) {
    ::setsockopt(one, IPPROTO_IPV6, IPV6_V6ONLY, &off, sizeof off);
  }
  if (::bind(one, address.ai_addr, address.ai_addrlen) == 0 && ::listen(one, kQueue) == 0) {
    return one;
  }
  ::close(one);
  return -1;
}

int listen_on(const std::string& host, int port) {
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  wanted.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  int listening = -1;
  if (::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &wanted, &found) == 0) {
    for (const addrinfo* one = found; one != nullptr && listening < 0; one = one->ai_next) {
      listening = listen_on(*one);
    }
    ::freeaddrinfo(found);
  }
  if (listening >= 0) return listening;
  throw ArgumentError(fmt::format(
      "{}:{}: cannot listen there; is another program using the port, or the address not of this "
      "machine?",
      host, port));
}

int port_of(int socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size);
  return address.ss_family == AF_INET6
             ? ntohs(reinterpret_cast<const sockaddr_in6*>(&address)->sin6_port)
             : ntohs(reinterpret_cast<const sockaddr_in*>(&address)->sin_port);
}

}  // namespace

struct Server::Impl {
  ServerConfig config;
  connections::BodyRoom room;
  int port;
  Lobby lobby;
  std::vector<std::jthread> workers;

  Impl(ServerConfig settings, std::unique_ptr<Descriptor> listening)
      : config(std::move(settings)),
        room(config.most_body_bytes),
        port(port_of(listening->number())),
        lobby(std::move(listening), config) {
    try {
      for (int k = 0; k < config.threads; ++k) workers.emplace_back([this] { work(); });
    } catch (...) {
      lobby.close();  // or those that run would wait for ever
      throw;
    }
  }

  void work() {
    while (auto guest = lobby.next()) {
      auto stay = Lobby::Stay::kNo;
      try {
        stay = serve(*guest);
      } catch (...) {
        // Of ServerConfig::refuse, or for want of memory: it costs this connection alone.
      }
      lobby.give_back(std::move(guest), stay);
    }
  }

  Response answer(Request request, const BodyReader& read_body) const {
    try {
      return config.answer(std::move(request), read_body);
    } catch (const HttpError& error) {
      return config.refuse(error);
    } catch (...) {
      return config.refuse(HttpError(500, "the server failed"));
    }
  }

  /// \returns whether the connection takes a further request
  Lobby::Stay serve(Guest& guest) {
    Response response;
    bool stays = ++guest.answered < kMostRequests && !guest.head.closes && !lobby.is_closed();
    {
      connections::RequestBody body(guest.socket, guest.head, guest.bytes, guest.group, room,
                                    config.body_seconds);
      BodyReader reader;
      if (guest.head.has_body()) reader = [&body](std::size_t most) { return body.read(most); };
      response = answer(std::move(guest.head.request), reader);
      stays = body.finish() && stays;
    }
    std::string text =
        head_text(response, stays ? connections::After::kStays : connections::After::kCloses);
    std::string_view rest = *response.body;
    if (guest.head.head_only || !connections::may_have_content(response.status)) rest = {};
    if (rest.size() <= kOnePacket) text += std::exchange(rest, {});
    const auto gives_up = [this] { return lobby.is_overdue(); };
    const bool sent = connections::send_all(guest.socket, text, gives_up) &&
                      connections::send_all(guest.socket, rest, gives_up);
    return sent && stays ? Lobby::Stay::kYes : Lobby::Stay::kNo;
  }
};

Server::Server(ServerConfig config) {
  check_range("port", config.port, 0, 65535);
  check_range("threads", config.threads, 1, 4096);
  check_range("stop_seconds", config.stop_seconds, 0, 3600);
  auto listening = std::make_unique<Descriptor>(listen_on(config.host, config.port));
  impl_ = std::make_unique<Impl>(std::move(config), std::move(listening));
}

Server::~Server() { stop(); }

int Server::port() const noexcept { return impl_->port; }

void Server::stop() {
  impl_->lobby.close();
  impl_->workers.clear();  // each ends with its request
}

}  // namespace enfilade::net
