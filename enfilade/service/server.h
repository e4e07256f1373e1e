/// \file  `enfilade serve`: a data set, its viewer and its evaluation over HTTP.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "enfilade/service/site.h"

namespace enfilade::service {

/// One answered request, for logs. Valid during the call.
struct RequestRecord {
  std::string_view address, method, path;
  int status = 0;
  std::size_t bytes = 0;   ///< of the answer's body
  double seconds = 0;      ///< until the answer was ready
  std::string_view who;    ///< team or organiser; empty for strangers
  std::string_view fault;  ///< of Enfilade's own (status 500): what it was
};

/// What a server serves, where, and within which limits.
struct ServerConfig {
  std::filesystem::path database;  ///< made if it isn't there
  std::string host = "127.0.0.1";  ///< interface to listen on
  int port = 8080;                 ///< 0: any that is free
  int threads = 256;               ///< connexions that are served at the same time
  /// Body of a submission. The 4,173 episodes of R2R's test take 1 to 6 MB.
  std::size_t most_submission_bytes = 32U << 20U;
  double body_seconds = 30;  ///< a body has to be there whole after that long
  /// Of registrations, and of tokens that nobody has, from an address in a minute.
  int most_attempts = 20;
  /// Of workers who come to a collection from an address in a minute: a lab's many share one.
  int most_joins = 600;
  /// Behind a proxy that sets X-Forwarded-For and X-Forwarded-Proto: believe them.
  bool behind_proxy = false;
  bool open_registration = true;  ///< anybody may make a team
  /// Called after each request, from many threads at once; may be empty.
  std::function<void(const RequestRecord&)> log;
  /// Seconds since 1970; empty: the system's clock.
  std::function<std::int64_t()> clock;
};

/// A running server. \warning The address has no encryption of its own: docs/service.md shows nginx
/// and Caddy in front of it.
class Server {
 public:
  /// Opens the database, bringing its schema up to date, binds the port and starts serving.
  /// \throws FileError for the database; ArgumentError if the address can't be bound
  Server(std::shared_ptr<const Site> site, const ServerConfig& config);
  /// As stop().
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  int port() const noexcept;
  /// Takes no new connexions, finishes the requests that are being answered and the submission
  /// that is being scored, and returns. What waits for its score is scored after the next start.
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Whether this build has the web client in it; without it the API alone is served.
bool has_web_client() noexcept;

/// Whose tokens are made and taken back by hand. Workers get theirs by their links.
enum class TokenRole {
  kOrganiser,  ///< makes collections, takes what they came to, sees hidden scores
  kReviewer,   ///< accepts, rejects and corrects what workers hand in
  kTeam,       ///< hands in results
};

/// Makes a token in a database (made if it isn't there), which a server may be using.
/// \returns the token: only its hash is kept
/// \param label whose it is; for kTeam the name of a team that is there
/// \param days until it expires; none: never
/// \throws FileError; ArgumentError for a bad label; LookupError if there is no such team
std::string create_token(const std::filesystem::path& database, TokenRole role,
                         const std::string& label, std::optional<int> days);

/// Takes back every token of that role and label. At once, for browsers that logged in by it too,
/// and for good. \returns how many there were  \throws FileError
int revoke_tokens(const std::filesystem::path& database, TokenRole role, const std::string& label);

/// Copies a database, also while a server uses it; the copy appears whole. \throws FileError
void back_up_database(const std::filesystem::path& database, const std::filesystem::path& copy);

}  // namespace enfilade::service
