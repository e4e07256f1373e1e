#include "enfilade/service/store/database.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/service/store/schema.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::service::store {
namespace {

using ::testing::HasSubstr;

int version_of(Database& database) {
  return static_cast<int>(database.find_number("PRAGMA user_version"));
}

TEST(Database, IsMadeWithTheNewestSchemaInWalMode) {
  const tests::TemporaryFolder folder("database");
  Database database(folder.path() / "a.sqlite");
  EXPECT_EQ(version_of(database), static_cast<int>(kMigrations.size()));
  EXPECT_EQ(database.find<std::string>("PRAGMA journal_mode"), "wal");
}

TEST(Database, KeepsItsContentWhenItIsOpenedAgain) {
  const tests::TemporaryFolder folder("database");
  for (int k = 0; k < 2; ++k) {
    Database database(folder.path() / "a.sqlite");
    database.run("INSERT INTO team (name, contact, created) VALUES (?, '', 0)",
                 "t" + std::to_string(k));
    EXPECT_EQ(database.find_number("SELECT count(*) FROM team"), k + 1);
  }
}

TEST(Database, ATransactionThatThrowsLeavesNothing) {
  const tests::TemporaryFolder folder("database");
  Database database(folder.path() / "a.sqlite");
  EXPECT_THROW(database.transact([&database] {
    database.run("INSERT INTO team (name, contact, created) VALUES ('t', '', 0)");
    throw LookupError("changed my mind");
  }),
               LookupError);
  EXPECT_EQ(database.find_number("SELECT count(*) FROM team"), 0);
}

struct Checkpoint {
  int blocked = 0;  // 1: by a statement that reads
  int pages = 0, moved = 0;

  auto columns() { return std::tie(blocked, pages, moved); }
};

// Statements are kept: a value of the last use, or a lock, would stay with them.
TEST(Database, AStatementThatRunsAgainHasNothingOfItsLastUse) {
  const tests::TemporaryFolder folder("database");
  Database database(folder.path() / "a.sqlite");
  const std::string insert = "INSERT INTO team (name, contact, created) VALUES (?, ?, 0)";
  database.run(insert, "a", "mail");
  EXPECT_THROW(database.run(insert, "a", "mail"), SQLite::Exception);  // the name is taken
  EXPECT_THROW(database.run(insert, "b"), SQLite::Exception);          // not "mail"
  database.run(insert, "b", "post");
  const std::string names = "SELECT name FROM team ORDER BY id";
  EXPECT_EQ(database.find<std::string>(names), "a");  // leaves it in the middle
  EXPECT_EQ(database.select<std::string>(names).size(), 2);
  EXPECT_EQ(database.find<std::string>(names), "a");
  Database other(database.file());
  EXPECT_EQ(other.get<Checkpoint>("PRAGMA wal_checkpoint(TRUNCATE)").blocked, 0);
}

TEST(Database, BearsMoreTextsThanItKeeps) {
  const tests::TemporaryFolder folder("database");
  Database database(folder.path() / "a.sqlite");
  for (int k = 1; k <= 1200; ++k) {
    ASSERT_EQ(database.find_number(fmt::format("SELECT {}", k)), k);
  }
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
  EXPECT_EQ(database.find_number("SELECT team FROM token WHERE hash = 'h'"), 3);
  EXPECT_EQ(database.find_number("SELECT expires FROM token WHERE hash = 'i'"), 9);
  EXPECT_EQ(database.find<std::string>(
                "SELECT token.label FROM session JOIN token ON token.id = session.token"),
            "Ada");
  EXPECT_EQ(database.find_number("SELECT count(*) FROM submission"), 1);
  // Nobody is approved for secret goals who was not looked at.
  EXPECT_EQ(database.find_number("SELECT count(*) FROM team WHERE approved IS NULL"), 1);
  EXPECT_EQ(database.find_number("SELECT count(*) FROM submission WHERE shown IS NULL AND ends IS "
                                 "NULL AND near_copy_of IS NULL"),
            1);
  for (const char* table : {"attempt", "phase_end", "secret"}) {
    EXPECT_EQ(database.find_number(std::string("SELECT count(*) FROM ") + table), 0);
  }
  EXPECT_FALSE(database.find<std::string>("PRAGMA foreign_key_check"));
  // References follow the tables' new names: a token with a session can't be deleted.
  EXPECT_THROW(database.run("DELETE FROM token WHERE hash = 'i'"), SQLite::Exception);
}

TEST(Database, ValuesComeBackAsTheyWere) {
  const tests::TemporaryFolder folder("database");
  Database database(folder.path() / "a.sqlite");
  database.run("CREATE TABLE kept (number INTEGER, real REAL, lines TEXT, bytes BLOB, none TEXT)");
  const std::string bytes("a\0b", 3);
  const std::vector<std::string> lines{"one", "two"};
  EXPECT_EQ(database.insert("INSERT INTO kept VALUES (?, ?, ?, ?, ?)", -3, 0.5, lines, Blob{bytes},
                            std::optional<std::string>()),
            1);
  using Kept = std::tuple<int, std::optional<double>, std::vector<std::string>, std::string,
                          std::optional<std::string>>;
  EXPECT_EQ(database.find<Kept>("SELECT * FROM kept"), Kept(-3, 0.5, lines, bytes, std::nullopt));
  EXPECT_EQ(database.find<Kept>("SELECT * FROM kept WHERE number = ?", 4), std::nullopt);
  EXPECT_EQ(database.get<double>("SELECT real FROM kept WHERE number = ?", -3), 0.5);
  EXPECT_THROW(database.get<double>("SELECT real FROM kept WHERE number = ?", 4), LookupError);
  EXPECT_EQ(database.run("DELETE FROM kept"), 1);
}

TEST(Database, OneOfANewerProgramIsRefused) {
  const tests::TemporaryFolder folder("database");
  const auto file = folder.path() / "a.sqlite";
  Database(file).run("PRAGMA user_version = 99");
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
  database.run("INSERT INTO team (name, contact, created) VALUES ('t', '', 0)");
  back_up(folder.path() / "a.sqlite", folder.path() / "copy.sqlite");
  back_up(folder.path() / "a.sqlite", folder.path() / "copy.sqlite");  // replaces the first
  Database copy(folder.path() / "copy.sqlite");
  EXPECT_EQ(copy.find<std::string>("SELECT name FROM team"), "t");
}

/// While it lives, new files get all rights that they are made with.
class NoUmask {
 public:
  NoUmask() : before_(::umask(0)) {}
  ~NoUmask() { ::umask(before_); }
  NoUmask(const NoUmask&) = delete;
  NoUmask& operator=(const NoUmask&) = delete;

 private:
  mode_t before_;
};

unsigned rights_of(const std::filesystem::path& file) {
  return static_cast<unsigned>(std::filesystem::status(file).permissions());
}

TEST(Database, OnlyItsOwnerMayReadItsFilesAndBackUps) {
  const NoUmask no_umask;
  const tests::TemporaryFolder folder("database");
  Database database(folder.path() / "a.sqlite");
  database.run("INSERT INTO team (name, contact, created) VALUES ('t', '', 0)");
  back_up(folder.path() / "a.sqlite", folder.path() / "copy.sqlite");
  for (const char* name : {"a.sqlite", "a.sqlite-wal", "a.sqlite-shm", "copy.sqlite"}) {
    EXPECT_EQ(rights_of(folder.path() / name), 0600U) << name;
  }
}

TEST(Database, OneThatOthersMayReadIsClosedToThem) {
  const NoUmask no_umask;
  const tests::TemporaryFolder folder("database");
  const auto file = folder.path() / "a.sqlite";
  // As the first versions of Enfilade left it, with a log: killed while it was open.
  SQLite::Database old(file.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
  old.exec("PRAGMA journal_mode = WAL; CREATE TABLE kept (a INTEGER)");
  ASSERT_NE(rights_of(file), 0600U);
  Database database(file);
  for (const char* name : {"a.sqlite", "a.sqlite-wal", "a.sqlite-shm"}) {
    EXPECT_EQ(rights_of(folder.path() / name), 0600U) << name;
  }
}

TEST(Database, OneThatMayNotBeWrittenIsRefused) {
  namespace fs = std::filesystem;
  const tests::TemporaryFolder folder("database");
  const auto file = folder.path() / "a.sqlite";
  { const Database made(file); }
  fs::permissions(file, fs::perms::owner_read | fs::perms::group_read | fs::perms::others_read);
  fs::permissions(folder.path(), fs::perms::all);
  const bool root = ::geteuid() == 0;  // who may write everything: as somebody else then
  constexpr uid_t kNobody = 65534;
  if (root) {
    ASSERT_EQ(::seteuid(kNobody), 0);
  }
  const std::string said = tests::refusal<FileError>([&file] { const Database database(file); });
  if (root) {
    ASSERT_EQ(::seteuid(0), 0);
  }
  EXPECT_THAT(said, HasSubstr("readonly"));
}

}  // namespace
}  // namespace enfilade::service::store
