/// \file  A client of HTTP for servers that may be broken or evil.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/proxy.h"

namespace enfilade::arena::detail {

/// "https", "model.invalid" and 443 of "https://model.invalid".
struct Host {
  bool encrypted = false;
  std::string name;  ///< without the brackets of an IPv6 address
  int port = 80;
};

/// What is of interest in a response.
struct Response {
  int status = 0;
  std::string type, retry_after;  ///< headers; empty: none
  std::string body;               ///< unpacked
};

/// Keeps one connection. Follows no redirect. The time of a response is limited as a whole: its
/// connection, handshake, request, head and body. The look-up of the host's name is not part of
/// it, as only a socket can be ended; the system limits that. The body has at most kMostAnswer
/// bytes, before and after it is unpacked. Its head has at most 64 KiB with all answers of 1xx
/// before it; so have the lines between two chunks, and the trailers. Its first line has at most
/// 2 KiB. A request that gets nothing on a connection from before is sent once more, on a new one:
/// the server may have ended it meanwhile. One thread at a time.
class BoundedClient {
 public:
  /// \param seconds for a whole response
  BoundedClient(const Host& host, const std::optional<Proxy>& proxy, double seconds);
  ~BoundedClient();
  BoundedClient(const BoundedClient&) = delete;
  BoundedClient& operator=(const BoundedClient&) = delete;

  using Headers = std::vector<std::pair<std::string, std::string>>;
  /// \param target "/v1/chat/completions?a=b" \throws EndpointError of status 0 for no response,
  /// one without an end, or one over the limits
  Response post(const std::string& target, const Headers& headers, std::string_view body);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::arena::detail
