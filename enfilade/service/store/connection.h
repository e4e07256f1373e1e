/// \file  Interface of a database: the same for SQLite and PostgreSQL.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "enfilade/core/errors.h"

namespace enfilade::service::store {

/// A statement failed, or the database cannot be reached; what() has the database's own words.
class DatabaseError : public Error {
 public:
  enum class Cause : std::uint8_t {
    kStatement,    ///< of the statement, or of the database's files
    kNoText,       ///< a text has a NUL, or is no UTF-8: PostgreSQL cannot hold it
    kDiskFull,     ///< the database found no room on its disk
    kUnreachable,  ///< the connection to a server is lost, or cannot be made; trying again may help
  };
  DatabaseError(Cause cause, const std::string& what) : Error(what), cause_(cause) {}
  Cause cause() const noexcept { return cause_; }

 private:
  Cause cause_;
};

/// How long a change waits for the changes of other programs before it fails.
inline constexpr int kBusyMilliseconds = 10'000;
/// Statements that a connection keeps prepared. There are fewer texts, unless some have values in
/// them.
inline constexpr std::size_t kMostStatements = 500;

/// One value for a statement.
struct Parameter {
  enum class Type : std::uint8_t { kInteger, kReal, kText, kBytes };

  Type type = Type::kInteger;  ///< also of a NULL
  /// By type; bytes stay the caller's.
  std::variant<std::monostate, std::int64_t, double, std::string, std::string_view> value = {};
};

/// The rows of a statement, from the first on. Columns count from 0.
class Rows {
 public:
  virtual ~Rows() = default;
  virtual bool next() = 0;  ///< goes to the next row (at first: to the first); false at the end
  virtual int columns() const = 0;
  virtual bool is_null(int column) const = 0;
  virtual std::int64_t integer(int column) const = 0;  ///< of a truth value 0 or 1
  virtual double real(int column) const = 0;
  virtual std::string text(int column) const = 0;  ///< or bytes
};

/// A connection, used by one thread at a time. Statements mark their values ?, or ?1, ?2. All
/// functions but the destructor and roll_back() \throw DatabaseError if they fail.
class Connection {
 public:
  virtual ~Connection() = default;

  /// Begins a transaction, after the end of every other one that changes something. Reads in it see
  /// the same state until its end.
  /// \pre in no transaction
  virtual void begin() = 0;
  /// All changes of the transaction are on the disk when this returns. \pre in a transaction
  virtual void commit() = 0;
  virtual void roll_back() noexcept = 0;
  /// \pre in a transaction  \returns how many rows were inserted, updated or deleted
  virtual int run(const std::string& sql, std::span<const Parameter> values) = 0;
  /// \returns the rows, to be read before the next statement
  virtual std::unique_ptr<Rows> select(const std::string& sql,
                                       std::span<const Parameter> values) = 0;

  /// Version of the schema (schema.h); 0: there are no tables yet.
  virtual int version() = 0;
  /// Runs a migration, and sets the version. \pre in a transaction
  virtual void migrate(const char* script, int version) = 0;

  /// Whether a file that was opened is still there under its name: of one that was removed or
  /// replaced, all that is written is lost. Always so of a server.
  virtual bool is_in_place() const = 0;
  /// Reads a row of every table, not from this process's memory. \throws FileError too
  virtual void check_readable() = 0;
  /// Writes a few unimportant bytes to the disk. \pre in a transaction
  virtual void check_writable() = 0;
  /// Free bytes on the database's disk, for this process; no value if unknown.
  virtual std::optional<std::uint64_t> free_bytes() const = 0;
};

/// Whether a place names a database of PostgreSQL (postgresql://USER@HOST/NAME, or postgres://)
/// rather than a file of SQLite.
bool is_url(std::string_view place);
/// Whether a URL has a password in it.
bool has_password(std::string_view place);
/// A place as logs and messages may have it: without password and options.
std::string shown(std::string_view place);

/// Opens a place; a file is made if it is missing. \throws FileError if that fails, or if this
/// build has no PostgreSQL
std::unique_ptr<Connection> connect(const std::string& place);

}  // namespace enfilade::service::store
