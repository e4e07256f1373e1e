#include "enfilade/service/detail/database.h"

#include <gmock/gmock.h>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/service/detail/schema.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::service::detail {
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
}  // namespace enfilade::service::detail
