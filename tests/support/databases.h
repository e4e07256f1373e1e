/// \file  Databases for tests, which all run on SQLite and, with ENFILADE_TEST_DATABASE=postgres,
/// on PostgreSQL.
#pragma once
#include <SQLiteCpp/SQLiteCpp.h>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include "enfilade/core/file.h"
#include "tests/support/postgres_server.h"

namespace enfilade::service::testing {

/// Whether the tests of this process use PostgreSQL.
inline bool on_postgres() {
  const char* named = std::getenv("ENFILADE_TEST_DATABASE");
  return named != nullptr && std::string_view(named) == "postgres";
}

/// The server of this process, started when it is first asked for. Ends the process with 77, for
/// ctest to skip, if none is installed.
inline tests::PostgresServer& postgres_server() {
  if (!tests::PostgresServer::programs()) {
    std::puts("skipped: no PostgreSQL server is installed (postgresql)");
    std::fflush(stdout);
    std::_Exit(77);
  }
  static tests::PostgresServer server;
  return server;
}

/// A place for a database of a test's own. \param file of SQLite
inline std::string new_database(const std::filesystem::path& file) {
  return on_postgres() ? postgres_server().make_schema() : file.string();
}

/// All that is in a database, in some form.
inline std::string content_of(const std::string& place) {
  return read_file(on_postgres() ? postgres_server().dump(place) : std::filesystem::path(place));
}

/// Does something that no server would, also while one uses the database.
inline void run_sql(const std::string& place, const std::string& sql) {
  if (on_postgres()) return postgres_server().run_sql(place, sql);
  SQLite::Database(place, SQLite::OPEN_READWRITE, 10'000).exec(sql);
}

/// While it lives, submissions cannot be changed.
class FrozenSubmissions {
 public:
  /// \param fault  what the database then says
  FrozenSubmissions(std::string place, const std::string& fault) : place_(std::move(place)) {
    run_sql(place_,
            on_postgres()
                ? "CREATE FUNCTION refuse() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN RAISE "
                  "EXCEPTION '" +
                      fault +
                      "'; END $$; CREATE TRIGGER frozen BEFORE UPDATE ON submission EXECUTE "
                      "FUNCTION refuse()"
                : "CREATE TRIGGER frozen BEFORE UPDATE ON submission BEGIN SELECT RAISE(ABORT, '" +
                      fault + "'); END");
  }
  ~FrozenSubmissions() {
    run_sql(place_, on_postgres() ? "DROP FUNCTION refuse CASCADE" : "DROP TRIGGER frozen");
  }
  FrozenSubmissions(const FrozenSubmissions&) = delete;
  FrozenSubmissions& operator=(const FrozenSubmissions&) = delete;

 private:
  std::string place_;
};

}  // namespace enfilade::service::testing

/// Ends a test about SQLite's file where the tests run on PostgreSQL.
#define EN_SKIP_ON_POSTGRES(reason) \
  if (::enfilade::service::testing::on_postgres()) GTEST_SKIP() << "PostgreSQL: " reason
