/// \file  The HTTP server of `enfilade serve`: viewer, evaluation and collection of instructions.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/progress.h"
#include "enfilade/service/site.h"

namespace enfilade::service {

/// One answered request, for logs. Valid during the call. A request that is refused before its head
/// is whole has the method "-" and no path. If the database fails while a submission is scored,
/// that is a record too: its method is "SCORE", its status 500, and it has a fault. So is trouble
/// that /healthz finds, once when it begins ("HEALTH", 503, with a fault) and once when it is over
/// ("HEALTH", 200).
struct RequestRecord {
  std::string_view address, method, path;
  int status = 0;
  std::size_t bytes = 0;   ///< of the answer's body
  double seconds = 0;      ///< until the answer was ready
  std::string_view who;    ///< name of the team, or label of the token; empty without one
  std::string_view fault;  ///< error of the server itself (status 500)
};

/// Address, data and limits of a server.
struct ServerConfig {
  /// A file, created if it is missing, or postgresql://USER\@HOST/NAME, a database of PostgreSQL:
  /// several servers of one data set may share it.
  std::string database;
  std::string host = "127.0.0.1";  ///< interface to listen on
  int port = 8080;                 ///< 0: any that is free
  int threads = 256;               ///< requests that are answered at the same time
  /// Largest body of a submission. The 4,173 episodes of R2R's test take 1 to 6 MB.
  std::size_t most_submission_bytes = 32U << 20U;
  double body_seconds = 30;  ///< longest time that a client may take to send a body
  /// Registrations, and requests with an unknown token, from one address in a minute.
  int most_attempts = 20;
  /// Joining workers and new sessions of the arena per address and minute: a whole lab may share an
  /// address.
  int most_joins = 600;
  /// Trust X-Forwarded-For and X-Forwarded-Proto: only behind a proxy that sets them.
  bool behind_proxy = false;
  /// Names by which visitors reach the server, "vln.example.org": requests for another one are
  /// refused (421), and changes from pages of another one (403). Addresses and "localhost" need not
  /// be given, nor this machine's name if `host` is not its own address alone.
  std::vector<std::string> public_names;
  /// With less room on the database's disk, /healthz reports trouble. Twice the largest submission,
  /// which is in SQLite's log first and then in the file.
  std::uint64_t least_free_bytes = 64U << 20U;
  /// Public runs of `enfilade ask`, `enfilade mcp` and Python's arena: the folder that holds
  /// theirs, or one of them. Empty: none.
  std::filesystem::path runs = {};
  /// Whether stores of the data set are being replaced by others with larger pictures. Browsers
  /// then ask for each picture again instead of keeping it for a day. Called by any thread; empty:
  /// the stores stay.
  std::function<bool()> pictures_change = {};
  bool open_registration = false;  ///< anyone can make a team; else only organisers
  /// Serve phases whose limits give away more bits than their secret goals have. Otherwise such
  /// phases are refused.
  bool accept_leak = false;
  /// Called at the start with sentences for the organiser, about leaks of secret goals; may be
  /// empty.
  std::function<void(std::string_view)> warn;
  /// Called after each request, also a refused one, and each failure of scoring, from many threads
  /// at once. Must not throw; may be empty.
  std::function<void(const RequestRecord&)> log;
  /// Seconds since 1970; empty: the system's clock.
  std::function<std::int64_t()> clock;
};

/// A running server, on threads of its own. \warning It serves plain HTTP: docs/service.md shows
/// nginx and Caddy in front of it.
class Server {
 public:
  /// Opens the database, bringing its schema up to date, binds the port and starts serving.
  /// \throws FileError for the database and for runs that are not a folder
  /// \throws InvalidInput for phases with limits that give their goals away (accept_leak)
  /// \throws ArgumentError if the address can't be bound, or for an invalid value of `config`
  Server(const std::shared_ptr<const Site>& site, const ServerConfig& config);
  /// Calls stop(), waits until the submission that is being scored is stored, and closes the
  /// database. Other queued submissions are scored after the next start. The same threads may call
  /// it as stop().
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  int port() const noexcept;  ///< the bound port; any thread.
  /// Accepts no new connections, and closes those that wait. Returns when the whole requests, up to
  /// 512 that wait for a thread too, are answered; clients that are slow to take their responses
  /// get 10 s. Scoring goes on until the destructor. A second call does nothing. Not safe to call
  /// from two threads at once, nor from ServerConfig::log, whose threads it waits for.
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// For the whole process: memory of 1 MiB or more goes back to the system when it is freed. Without
/// this, glibc keeps it once a large body was freed, up to 64 MiB for each of its arenas. To be
/// called at the start of a server's program. Does nothing with other C libraries.
void give_back_large_memory() noexcept;

/// Whether this build contains the web client; without it only the API is served.
bool has_web_client() noexcept;

/// Roles of clients. Their tokens are created and revoked by hand; workers get theirs by links.
enum class TokenRole : std::uint8_t {
  kTeam,       ///< submits results
  kOrganiser,  ///< creates and exports collections, sees hidden scores
  kReviewer,   ///< accepts, rejects and corrects what workers submit
  kWorker,     ///< does the tasks of a collection
};
constexpr std::array<std::string_view, 4> names_of(TokenRole /*enum*/) {
  return {"team", "organiser", "reviewer", "worker"};
}

/// Whether a database's URL has a password in it: other users can read command lines.
bool has_password(const std::string& database);

/// ServerConfig::database as messages may have it: of a URL without password and options.
std::string shown_database(const std::string& database);

/// Creates a token in a database (created if it is missing), also while a server uses it.
/// \returns the token; only its hash is stored
/// \param label of the holder; for kTeam the name of an existing team
/// \param days until it expires; no value: never
/// \pre role is not kWorker
/// \throws FileError; ArgumentError for a bad label; LookupError for an unknown team
std::string create_token(const std::string& database, TokenRole role, const std::string& label,
                         std::optional<int> days);

/// Revokes every token of that role and label, and the browser sessions that it began, at once and
/// for good.
/// \returns the number of tokens
/// \throws FileError
int revoke_tokens(const std::string& database, TokenRole role, const std::string& label);

/// Makes a team, as organisers do: it is approved. \returns its token, shown this once
/// \throws FileError; Error if the name is taken, or is not 1 to 80 printable characters
std::string create_team(const std::string& database, const std::string& name);

/// Whether a team may submit to phases with secret goals.
enum class Approval { kGiven, kWithdrawn };

/// Approves a team, or withdraws its approval, at once, also while a server uses the database.
/// \throws FileError; LookupError if there is no such team
void set_approval(const std::string& database, const std::string& team, Approval approval);

/// Copies a database's file, also while a server uses it; the copy is written beside its
/// destination and renamed.
/// \throws FileError; ArgumentError for PostgreSQL, which has pg_dump
void back_up_database(const std::string& database, const std::filesystem::path& copy);

/// Copies a whole file into an unused database of PostgreSQL: all of it, or nothing. No server may
/// use the file meanwhile. It is not changed, except its schema.
/// \returns the number of rows
/// \throws FileError; ArgumentError for other places than those
std::int64_t copy_to_postgres(const std::string& file, const std::string& url,
                              const Progress& progress);

}  // namespace enfilade::service
