/// \file  Requests and responses of HTTP as a server's program sees them.
#pragma once
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"

namespace enfilade::net {

/// Bodies up to this many bytes are read at any time: pages and scripts send them all the time.
/// Only larger ones are counted, and wait for their turn.
inline constexpr std::size_t kSmallBody = 16U << 10U;

using Texts = std::map<std::string, std::string, std::less<>>;  ///< by name

/// A request that is wrong as a message of HTTP: its form, its size, its sender.
class HttpError : public Error {
 public:
  /// \param status from 400 to 599  \param message for the client
  HttpError(int status, const std::string& message) : Error(message), status_(status) {}
  int status() const noexcept { return status_; }

 private:
  int status_;
};

/// A request whose head is well formed. Its body is read by BodyReader.
struct Request {
  std::string method;   ///< "GET", "POST", "DELETE"; HEAD comes as GET
  std::string target;   ///< as it was sent: "/path?name=value"
  std::string path;     ///< decoded, without the query
  Texts headers;        ///< names in lower case; lines of one name are one list
  std::string address;  ///< of the client

  std::string_view header(std::string_view name) const;  ///< "" if absent
};

/// A response, with a whole body.
struct Response {
  int status = 200;
  std::string type = "application/json";
  /// Shared: pictures and the pages' files are the same for everybody.
  std::shared_ptr<const std::string> body = std::make_shared<const std::string>();
  std::vector<std::pair<std::string, std::string>> headers;

  /// The first header of that name, written as it was added.
  std::optional<std::string_view> header(std::string_view name) const;
  /// A header with a line break is not sent.
  void add_header(std::string name, std::string value);
};

/// Reads a request's body, unpacked if it is gzip. Called at most once.
/// \throws HttpError
/// - 413 for more than `most` bytes, or a body that unpacks to more than 200 times its size
/// - 503 if there is no room for it (both without reading on)
/// - 408, 400; 415 for an encoding other than gzip
using BodyReader = std::function<std::string(std::size_t most)>;

}  // namespace enfilade::net
