/// \file  Requests and responses as routes see them, whatever library carries them, and the headers
/// that all responses get.
#pragma once
#include <cstdint>
#include <exception>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/net/messages.h"
#include "enfilade/service/accounts/tokens.h"
#include "enfilade/service/server.h"

namespace enfilade::service::http {

using net::HttpError;  // refusals by rules of the service are detail::Refusal
using net::Texts;

struct Request : net::Request {
  Texts query;  ///< decoded; of repeated names the first
  std::string body;
  Texts parameters;                              ///< of the route's pattern
  std::optional<accounts::Principal> principal;  ///< the sender, if identified

  /// \pre the route's pattern has {name}
  const std::string& parameter(std::string_view name) const;
  /// As parameter(), a whole number. \throws HttpError 404 with `missing` for any other text
  std::int64_t id(std::string_view name, const char* missing) const;
  /// A whole number of the query. \throws HttpError 400 for any other text, or out of range
  std::int64_t number(std::string_view name, std::int64_t otherwise, std::int64_t least,
                      std::int64_t most) const;
  std::string text(std::string_view name) const;  ///< of the query; "" if absent

  std::optional<accounts::ClientRole> role() const {  ///< of the sender, if identified
    return principal ? std::optional(principal->role) : std::nullopt;
  }
  bool is_from(accounts::ClientRole wanted) const { return role() == wanted; }
  /// \throws HttpError 401 if the client is not identified
  const accounts::Principal& known_principal() const;
};

/// The query of a request's target, "/path?name=value&other", decoded: %20 and + are blanks, a
/// value may have more =, and % without two digits stays as it is.
Texts parse_query(std::string_view target);

struct Response : net::Response {
  bool frameable = false;  ///< its own Content-Security-Policy lists the sites that may frame it
  std::string problem;     ///< of errors: the fault, for people; it may quote the request
};
Response json_response(const nlohmann::ordered_json& json, int status = 200);
Response text_response(std::string type, std::string text);
/// The same bytes for all requests.
Response shared_response(std::string type, std::shared_ptr<const std::string> body);
Response csv_response(std::string csv);
/// A file to be saved.
Response file_response(std::string type, std::string content, const std::string& name);

/// {"error": {"code", "message"}}, with "diagnostics" if there are any: at most 200 of them, and
/// how many there were. The code is the word of the status: "not-found" of 404.
Response error_response(int status, std::string_view message,
                        const std::vector<Diagnostic>& diagnostics = {});
/// As above with a code of its own, which is not the status's.
Response error_response(int status, std::string_view code, std::string_view message);
/// The response to an exception of a route: the one place where errors get their status.
/// \param fault fault of the server itself (status 500), for its log only: it may name local files
Response error_response(const std::exception_ptr& thrown, std::string& fault);

/// The body as a JSON object. \throws HttpError 400 if it is not one, or beyond detail::kFormLimits
nlohmann::ordered_json parse_object(const std::string& body);
/// A field of an object that must be there. \param is of JSON: &ordered_json::is_array
/// \param what "a list", for the message of HttpError 400
const nlohmann::ordered_json& form_field(const nlohmann::ordered_json& object, const char* name,
                                         bool (nlohmann::ordered_json::*is)() const noexcept,
                                         const char* what);
enum class Presence : std::uint8_t { kRequired, kOptional };
/// A text of an object. \throws HttpError 400 if it is not a text, or is required and absent
std::string text_field(const nlohmann::ordered_json& object, const char* name,
                       Presence presence = Presence::kRequired);

/// The fields of a request's body. Faults are collected, so that a client gets all at once: a field
/// with a fault reads as "" or `otherwise`.
class Form {
 public:
  /// \throws HttpError as parse_object()
  explicit Form(const std::string& body);
  ~Form();
  Form(const Form&) = delete;
  Form& operator=(const Form&) = delete;

  bool has(const char* name) const;
  std::string text(const char* name, Presence presence = Presence::kRequired);
  /// A whole number; `otherwise` for null and an absent field.
  std::int64_t whole(const char* name, std::int64_t otherwise, std::int64_t least,
                     std::int64_t most);
  /// Adds a fault that the route found.
  void add_fault(std::string_view fault);
  /// \throws HttpError 400 with all faults, if there are any
  void check() const;

 private:
  std::unique_ptr<nlohmann::ordered_json> object_;
  std::string faults_;
};

// Headers of responses: security, compression, caching.

bool accepts_gzip(const Request& request);
/// Compresses a text that is long enough, for a client that accepts it.
void compress(const Request& request, Response& response);
/// Adds an ETag of its body. Browsers ask each time, and mostly get a 304.
void add_digest(Response& response);
/// Makes it a 304 if the client's cached copy has the same ETag.
void compare_with_cached(const Request& request, Response& response);

/// Whether the visitor's side of the connection is encrypted, as a trusted proxy reports.
bool is_encrypted(const Request& request, const ServerConfig& config);
/// The name of the session's cookie. A browser sends a host's cookies to all its ports. So the
/// visitor's port is part of the name, or two servers would log each other's visitors out. On
/// encrypted connections it begins with "__Host-", so pages of the domain's other hosts cannot set
/// it.
std::string session_cookie(const Request& request, const ServerConfig& config);

/// A Content-Security-Policy: scripts and styles from the server's own files only, pictures from it
/// and from memory.
std::string content_policy(std::string_view form_action, std::string_view frame_ancestors);

/// Adds the security headers that the response does not have yet.
void add_security_headers(Response& response);

}  // namespace enfilade::service::http
