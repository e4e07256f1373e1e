/// \file  A model's endpoint: a server on the network, which may be busy or fail. Its responses are
/// cached by request, so a run can be continued and replayed at no cost.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/arena/session.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/output_folder.h"

namespace enfilade::arena {

/// What a server says about a request that it does not answer.
struct Refusal {
  int status = 0;    ///< of HTTP; 0: no connection, or no whole answer in time
  std::string body;  ///< as it came, mostly JSON; may be empty
};

/// A request that got no answer.
class EndpointError : public Error {
 public:
  /// \param status  as Refusal's \param wait  seconds, as wait() \param body  of the response
  EndpointError(int status, const std::string& message, std::optional<double> wait = {},
                std::string body = {})
      : Error(message), refusal_{status, std::move(body)}, wait_(wait) {}
  int status() const noexcept { return refusal_.status; }
  const Refusal& refusal() const noexcept { return refusal_; }
  /// Seconds after which the server accepts a retry (`Retry-After`).
  std::optional<double> wait() const noexcept { return wait_; }
  /// Whether the same request may succeed later: no connection, 408, 409, 425, 429, 5xx. Not 501,
  /// and not 500 with a text that says that the request was invalid.
  bool passes() const;

 private:
  Refusal refusal_;
  std::optional<double> wait_;
};

/// A refusal that waiting does not change.
class RequestRefused : public InvalidInput {
 public:
  /// \param episode  "r2r/val_unseen/1_0", for the message
  RequestRefused(const std::string& episode, const EndpointError& error);
  const Refusal& refusal() const noexcept { return refusal_; }

 private:
  Refusal refusal_;
};

/// Where a request comes from. It is no part of the body, so the model does not get it.
struct RequestOrigin {
  std::string episode;      ///< "r2r/val_unseen/1_0"
  std::vector<Call> calls;  ///< accepted calls of the episode
};

/// Something that answers chat requests.
class Endpoint {
 public:
  virtual ~Endpoint() = default;
  Endpoint(const Endpoint&) = delete;
  Endpoint& operator=(const Endpoint&) = delete;
  /// The body of the answer to a body. Any thread. \throws EndpointError
  virtual std::string post(std::string_view body, const RequestOrigin& origin) = 0;

 protected:
  Endpoint() = default;
};

/// A response, and its cost.
struct KeptAnswer {
  std::string answer;  ///< the body as it came: a chat completion of OpenAI's form, JSON
  double seconds = 0;  ///< from the request that was answered to its answer
  int attempts = 1;    ///< requests that were made for it
};

/// The response cannot be had now; others may be.
class GivenUp : public Error {
 public:
  using Error::Error;
};

/// Most seconds between two attempts, unless the server says more.
inline constexpr double kLongestWait = 60;
/// Most seconds that a server may ask for (`Retry-After`), if the caller sets no other limit.
inline constexpr double kLongestAskedWait = 300;
/// Attempts and back-off of requests.
struct Patience {
  int attempts = 6;  ///< requests before it is given up
  double first_wait =
      1;  ///< seconds after the first failure; doubled each time, at most kLongestWait
  /// Waits for a number of seconds. \returns false if the response is no longer needed
  std::function<bool(double seconds)> pause;
  double longest_wait =
      kLongestAskedWait;  ///< seconds: no wait is longer, whatever the server asks
  /// Gets a sentence before a wait that the server asked for; may be empty. Any thread.
  std::function<void(const std::string& sentence)> say = {};
};

/// Sends a body until a response comes that `read` accepts; it throws InvalidInput for others.
/// \throws GivenUp after the last attempt, also of answers that memory does not suffice for
/// \throws RequestRefused for a refusal that waiting does not change
KeptAnswer post_patiently(Endpoint& endpoint, std::string_view body, const RequestOrigin& origin,
                          const Patience& patience,
                          const std::function<void(std::string_view answer)>& read);

/// A server on the network. Only in builds with EN_WITH_WEB.
struct HttpEndpointConfig {
  /// "http://127.0.0.1:8000/v1": /chat/completions is added, before a query.
  std::string url;
  std::string key = {};         ///< sent as `Authorization: Bearer`, and never shown; empty: none
  std::string key_header = {};  ///< the header that has the key alone ("api-key"), in its place
  std::vector<std::pair<std::string, std::string>> headers = {};  ///< of each request; never shown
  double timeout = 120;  ///< seconds to wait for a whole answer, (0, 3600]
};
/// Keeps a connection per thread, through the proxy that proxy_for() names. Sends the origin as
/// `X-Enfilade-Episode` and `X-Enfilade-Calls` ("go_to B; stop"). A response in parts
/// (`text/event-stream`) is joined to one. A header of the key's name takes the key's place. Where
/// a response or refusal has the key, or a header's value, it has "(key)" instead: as it is,
/// escaped, in base64. Those of fewer than 8 bytes count as whole words only. So short a header's
/// value counts only if the name has "auth", "cookie", "key", "login", "secret" or "token" in it.
/// Responses have limits (docs/arena.md).
/// \throws ArgumentError for a URL that is not http:// or https://
/// \throws ArgumentError for a URL with a user, a password or a key in its query
/// \throws ArgumentError for a key, or a header, with bytes that are not printable ASCII
/// \throws as proxy_for()
std::unique_ptr<Endpoint> make_http_endpoint(const HttpEndpointConfig& config);

/// Headers of a file: lines "Name: value"; empty lines and those that begin with '#' are left out.
/// \throws FileError; InvalidInput naming the line, and not what is in it
std::vector<std::pair<std::string, std::string>> load_headers(const std::filesystem::path& file);

/// The chat completion of a response in parts (server-sent events), as a body of JSON; an event
/// with an error is returned as it is.
/// \throws EndpointError if it ends too early, or an event is no JSON object
std::string join_events(std::string_view events);

/// A folder of responses, one file each. A file has the request too, with its pictures by their
/// keys. Any number of threads and processes may use one; its files are complete, also after a
/// process was killed. It writes behind no link in the folder.
class AnswerCache {
 public:
  /// Makes the folder. \throws FileError
  explicit AnswerCache(std::filesystem::path folder)
      : AnswerCache(OutputFolder(std::move(folder))) {}
  explicit AnswerCache(OutputFolder folder) : folder_(std::move(folder)) {}

  /// 32 hex digits of a request (XXH3, 128 bits).
  static std::string key_of(std::string_view request);

  /// \throws FileError; InvalidInput for a file that is damaged or of another request
  std::optional<KeptAnswer> find(std::string_view request) const;
  /// The same by key_of() a request; no value for another text.
  std::optional<KeptAnswer> find_key(const std::string& key) const;
  /// The answer that is kept, or the one that `ask` gives, which is kept before this returns. Two
  /// threads that ask the same at once ask once. \throws what find() and `ask` throw; FileError
  KeptAnswer get(std::string_view request, const std::function<KeptAnswer()>& ask);

 private:
  static std::string name_of(const std::string& key);  // of a file in the folder

  OutputFolder folder_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::set<std::string, std::less<>> asking_;  // keys
};

}  // namespace enfilade::arena
