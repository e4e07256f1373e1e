#include "enfilade/service/store/database.h"

#include <gmock/gmock.h>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/service/store/schema.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::service::store {
namespace {

using ::testing::HasSubstr;

int version_of(Database& database) {
  return database.with(
      [](SQLite::Database& db) { return db.execAndGet("PRAGMA user_version").getInt(); });
}

TEST(Database, IsMadeWithTheNewestSchemaInWalMode) {
  const tests::TemporaryFolder folder("database");
  Database database(folder.path() / "a.sqlite");
  EXPECT_EQ(version_of(database), static_cast<int>(kMigrations.size()));
  EXPECT_EQ(database.with([](SQLite::Database& db) {
    return db.execAndGet("PRAGMA journal_mode").getString();
  }),
            "wal");
}

TEST(Database, KeepsItsContentWhenItIsOpenedAgain) {
  const tests::TemporaryFolder folder("database");
  for (int k = 0; k < 2; ++k) {
    Database database(folder.path() / "a.sqlite");
    database.transact([k](SQLite::Database& db) {
      db.exec("INSERT INTO team (name, contact, created) VALUES ('t" + std::to_string(k) +
              "', '', 0)");
    });
    EXPECT_EQ(database.with([](SQLite::Database& db) {
      return db.execAndGet("SELECT count(*) FROM team").getInt();
    }),
              k + 1);
  }
}

TEST(Database, ATransactionThatThrowsLeavesNothing) {
  const tests::TemporaryFolder folder("database");
  Database database(folder.path() / "a.sqlite");
  EXPECT_THROW(database.transact([](SQLite::Database& db) {
    db.exec("INSERT INTO team (name, contact, created) VALUES ('t', '', 0)");
    throw LookupError("changed my mind");
  }),
               LookupError);
  EXPECT_EQ(database.with([](SQLite::Database& db) {
    return db.execAndGet("SELECT count(*) FROM team").getInt();
  }),
            0);
}

/// A database as the first version of the schema left it, with somebody logged in.
void write_version_1(const std::filesystem::path& file) {
  SQLite::Database db(file.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
  db.exec(kMigrations[0]);
  db.exec(
      "PRAGMA user_version = 1;"
      "INSERT INTO team (id, name, contact, created) VALUES (3, 'A', '', 5);"
      "INSERT INTO token (id, hash, role, team, label, created) VALUES (1, 'h', 'team', 3, 'A', 5);"
      "INSERT INTO token (id, hash, role, label, created, expires) "
      "VALUES (2, 'i', 'organiser', 'Ada', 5, 9);"
      "INSERT INTO session VALUES ('s', 2, 9);"
      "INSERT INTO submission (team, phase, method, created, state, digest, content) "
      "VALUES (3, 'p', 'm', 5, 'queued', 'd', x'00')");
}

TEST(Database, AnOlderOneIsBroughtUpToDateWithAllThatIsInIt) {
  const tests::TemporaryFolder folder("database");
  const auto file = folder.path() / "a.sqlite";
  write_version_1(file);
  Database database(file);
  EXPECT_EQ(version_of(database), static_cast<int>(kMigrations.size()));
  database.with([](SQLite::Database& db) {
    EXPECT_EQ(db.execAndGet("SELECT team FROM token WHERE hash = 'h'").getInt(), 3);
    EXPECT_EQ(db.execAndGet("SELECT expires FROM token WHERE hash = 'i'").getInt(), 9);
    EXPECT_EQ(db.execAndGet("SELECT token.label FROM session JOIN token ON token.id = "
                            "session.token")
                  .getString(),
              "Ada");
    EXPECT_EQ(db.execAndGet("SELECT count(*) FROM submission").getInt(), 1);
    SQLite::Statement broken(db, "PRAGMA foreign_key_check");
    EXPECT_FALSE(broken.executeStep());
    // References follow the tables' new names: whoever has a session can't be deleted.
    EXPECT_THROW(db.exec("DELETE FROM token WHERE hash = 'i'"), SQLite::Exception);
  });
}

TEST(Database, OneOfANewerProgramIsRefused) {
  const tests::TemporaryFolder folder("database");
  const auto file = folder.path() / "a.sqlite";
  Database(file).with([](SQLite::Database& db) { db.exec("PRAGMA user_version = 99"); });
  EXPECT_THAT(tests::refusal<FileError>([&file] { const Database again(file); }),
              HasSubstr("its schema has version 99"));
}

TEST(Database, AnotherFileIsRefusedAndLeftAsItWas) {
  const tests::TemporaryFolder folder("database");
  const auto file = folder.path() / "a.sqlite";
  const std::string content(4096, 'x');
  write_file_atomically(file, content);
  EXPECT_THAT(tests::refusal<FileError>([&file] { const Database database(file); }),
              HasSubstr("not a usable database"));
  EXPECT_EQ(read_file(file), content);
}

TEST(Database, ABackUpIsMadeWhileItIsOpen) {
  const tests::TemporaryFolder folder("database");
  Database database(folder.path() / "a.sqlite");
  database.transact([](SQLite::Database& db) {
    db.exec("INSERT INTO team (name, contact, created) VALUES ('t', '', 0)");
  });
  back_up(folder.path() / "a.sqlite", folder.path() / "copy.sqlite");
  back_up(folder.path() / "a.sqlite", folder.path() / "copy.sqlite");  // replaces the first
  Database copy(folder.path() / "copy.sqlite");
  EXPECT_EQ(copy.with([](SQLite::Database& db) {
    return db.execAndGet("SELECT name FROM team").getString();
  }),
            "t");
}

}  // namespace
}  // namespace enfilade::service::store
