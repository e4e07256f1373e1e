#include "enfilade/service/store/database.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>
#include <array>
#include <atomic>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <thread>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "tests/support/databases.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::service::store {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kNewest = static_cast<int>(kMigrations.size());

int version_of(Database& database) {
  return static_cast<int>(database.find_number(
      testing::on_postgres() ? "SELECT version FROM enfilade_schema" : "PRAGMA user_version"));
}

/// A place for a database.
class Place {
 public:
  operator const std::string&() const { return name_; }

 private:
  tests::TemporaryFolder folder_{"database"};
  std::string name_ = testing::new_database(folder_.path() / "a.sqlite");
};

TEST(Database, IsMadeWithTheNewestSchema) {
  const Place place;
  Database database(place);
  EXPECT_EQ(version_of(database), kNewest);
  if (!testing::on_postgres()) {
    EXPECT_EQ(database.find<std::string>("PRAGMA journal_mode"), "wal");
  }
}

TEST(Database, OfSeveralThatOpenItAtOnceOneMakesIt) {
  const Place place;
  std::vector<std::thread> threads;
  std::atomic<int> good{0};
  for (int k = 0; k < 8; ++k) {
    threads.emplace_back([&] {
      Database database(place);
      if (version_of(database) == kNewest) ++good;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(good, 8);
}

// As several servers do: what was read in a transaction stays so until its end.
TEST(Database, ChangesOfSeveralProgramsComeOneAfterAnother) {
  const Place place;
  constexpr int kPrograms = 4, kTimes = 25;
  { Database(place).run("INSERT INTO team (name, contact, created) VALUES ('t', '', 0)"); }
  std::vector<std::thread> programs;
  for (int k = 0; k < kPrograms; ++k) {
    programs.emplace_back([&place] {
      Database database(place);
      for (int times = 0; times < kTimes; ++times) {
        database.transact([&database] {
          const std::int64_t read = database.find_number("SELECT created FROM team");
          database.run("UPDATE team SET created = ?", read + 1);
        });
        database.run("UPDATE team SET contact = contact || 'x'");
      }
    });
  }
  for (std::thread& program : programs) program.join();
  Database database(place);
  EXPECT_EQ(database.find_number("SELECT created FROM team"), kPrograms * kTimes);
  EXPECT_EQ(database.find_number("SELECT length(contact) FROM team"), kPrograms * kTimes);
}

TEST(Database, KeepsItsContentWhenItIsOpenedAgain) {
  const Place place;
  for (int k = 0; k < 2; ++k) {
    Database database(place);
    database.run("INSERT INTO team (name, contact, created) VALUES (?, '', 0)",
                 "t" + std::to_string(k));
    EXPECT_EQ(database.find_number("SELECT count(*) FROM team"), k + 1);
  }
}

TEST(Database, ATransactionThatThrowsLeavesNothing) {
  const Place place;
  Database database(place);
  EXPECT_THROW(database.transact([&database] {
    database.run("INSERT INTO team (name, contact, created) VALUES ('t', '', 0)");
    throw LookupError("changed my mind");
  }),
               LookupError);
  EXPECT_EQ(database.find_number("SELECT count(*) FROM team"), 0);
}

TEST(Database, ATransactionOfWhichAStatementHasFailedIsNotKeptInPart) {
  const Place place;
  Database database(place);
  EXPECT_THROW(database.transact([&database] {
    database.run("INSERT INTO team (name, contact, created) VALUES ('t', '', 0)");
    database.run("INSERT INTO team (name, contact, created) VALUES ('T', '', 0)");
  }),
               DatabaseError);
  EXPECT_EQ(database.find_number("SELECT count(*) FROM team"), 0);
}

struct Checkpoint {
  int blocked = 0;  // 1: by a statement that reads
  int pages = 0, moved = 0;

  auto columns() { return std::tie(blocked, pages, moved); }
};

// Statements are kept: a value of the last use, or a lock, would stay with them.
TEST(Database, AStatementThatRunsAgainHasNothingOfItsLastUse) {
  const Place place;
  Database database(place);
  const std::string insert = "INSERT INTO team (name, contact, created) VALUES (?, ?, 0)";
  database.run(insert, "a", "mail");
  EXPECT_THROW(database.run(insert, "a", "mail"), DatabaseError);  // the name is taken
  EXPECT_THROW(database.run(insert, "b"), DatabaseError);          // not "mail"
  database.run(insert, "b", "post");
  const std::string names = "SELECT name FROM team ORDER BY id";
  EXPECT_EQ(database.find<std::string>(names), "a");  // leaves it in the middle
  EXPECT_EQ(database.select<std::string>(names).size(), 2);
  EXPECT_EQ(database.find<std::string>(names), "a");
  if (testing::on_postgres()) return;  // where readers block nobody
  Database other(place);
  EXPECT_EQ(other.get<Checkpoint>("PRAGMA wal_checkpoint(TRUNCATE)").blocked, 0);
}

TEST(Database, BearsMoreTextsThanItKeeps) {
  const Place place;
  Database database(place);
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
  EN_SKIP_ON_POSTGRES("no version had it before the newest of these migrations");
  const tests::TemporaryFolder folder("database");
  const auto file = folder.path() / "a.sqlite";
  write_version_1(file);
  Database database(file);
  EXPECT_EQ(version_of(database), kNewest);
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
  EXPECT_EQ(database.find_number("SELECT count(*) FROM submission WHERE rule IS NULL"), 1);
  EXPECT_EQ(database.find_number("SELECT count(*) FROM submission WHERE walks_public = 0 AND "
                                 "weights = 'unsaid' AND description = '' AND bibtex = ''"),
            1);
  for (const char* table : {"attempt", "phase_end", "phase_rule", "secret"}) {
    EXPECT_EQ(database.find_number(std::string("SELECT count(*) FROM ") + table), 0);
  }
  EXPECT_FALSE(database.find<std::string>("PRAGMA foreign_key_check"));
  // References follow the tables' new names: a token with a session can't be deleted.
  EXPECT_THROW(database.run("DELETE FROM token WHERE hash = 'i'"), DatabaseError);
}

TEST(Database, ValuesComeBackAsTheyWere) {
  const Place place;
  Database database(place);
  database.run(
      testing::on_postgres()
          ? "CREATE TABLE kept (id BIGINT GENERATED BY DEFAULT AS IDENTITY, number BIGINT, "
            "real DOUBLE PRECISION, lines TEXT, bytes BYTEA, none TEXT)"
          : "CREATE TABLE kept (id INTEGER PRIMARY KEY, number INTEGER, real REAL, lines "
            "TEXT, bytes BLOB, none TEXT)");
  const std::string bytes("a\0b\\\xff'", 6);
  const std::vector<std::string> lines{"one", "two \\ é '"};
  const std::string insert =
      "INSERT INTO kept (number, real, lines, bytes, none) VALUES (?, ?, ?, ?, ?)";
  EXPECT_EQ(database.insert(insert, -3, 0.1, lines, Blob{bytes}, std::optional<std::string>()), 1);
  using Kept = std::tuple<int, std::optional<double>, std::vector<std::string>, std::string,
                          std::optional<std::string>>;
  const std::string select = "SELECT number, real, lines, bytes, none FROM kept ";
  EXPECT_EQ(database.find<Kept>(select), Kept(-3, 0.1, lines, bytes, std::nullopt));
  EXPECT_EQ(database.find<Kept>(select + "WHERE number = ?", 4), std::nullopt);
  EXPECT_EQ(database.get<double>("SELECT real FROM kept WHERE number = ?", -3), 0.1);
  EXPECT_THROW(database.get<double>("SELECT real FROM kept WHERE number = ?", 4), LookupError);
  constexpr auto kLargest = std::numeric_limits<std::int64_t>::max();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(database.insert(insert, kLargest, -kInfinity, "", Blob{""}, ""), 2);
  EXPECT_EQ(database.find_number("SELECT number FROM kept WHERE real = ?", -kInfinity), kLargest);
  EXPECT_EQ(database.find_number("SELECT count(*) FROM kept WHERE bytes = ?", Blob{""}), 1);
  EXPECT_EQ(database.get<bool>("SELECT none IS NULL FROM kept WHERE number = ?", -3), true);
  EXPECT_EQ(database.run("DELETE FROM kept"), 2);
}

TEST(Database, ValuesAreBoundInTheirOrderOrByNumber) {
  const Place place;
  Database database(place);
  database.run("INSERT INTO team (name, contact, created) VALUES (?2, 'why?', ?1)", 5, "a");
  using Both = std::tuple<std::string, int>;
  EXPECT_EQ(database.get<Both>("SELECT contact, created FROM team WHERE name = ?2 AND ? > created "
                               "AND created = ?1",
                               5, "a", 6),
            Both("why?", 5));
}

// By their bytes, whatever the language of the database's server.
TEST(Database, TextsAreSortedByTheirBytes) {
  const Place place;
  Database database(place);
  for (const char* name : {"b", "B", "a", "é", "_"}) {
    database.run(
        "INSERT INTO collection (name, title, kind, open, link_key, platform, origins, "
        "completion_code, consent, instructions, per_item, lease_seconds, "
        "tasks_per_visit, created) VALUES (?, '', 'walk', 1, '', 'self', '', '', '', '', "
        "1, 1, 1, 0)",
        name);
  }
  EXPECT_THAT(database.select<std::string>("SELECT name FROM collection ORDER BY name"),
              ElementsAre("B", "_", "a", "b", "é"));
}

TEST(Database, MessagesHaveNoPassword) {
  for (const auto& [place, as] : std::map<std::string, std::string>{
           {"postgresql://u:secret@h:5/d", "postgresql://u@h:5/d"},
           {"postgres://u:sec/r@et@h/d?password=secret", "postgres://u@h/d"},
           {"postgresql:///d?user=u&password=secret", "postgresql:///d"}}) {
    EXPECT_TRUE(has_password(place)) << place;
    EXPECT_EQ(shown(place), as);
    const std::string said = tests::refusal<FileError>([&] { const Database database(place); });
    EXPECT_THAT(said, AllOf(HasSubstr(as), Not(HasSubstr("sec")))) << place;
  }
  EXPECT_FALSE(has_password("postgresql://u@h:5/d"));
  EXPECT_EQ(shown("postgresql://u@h:5/d"), "postgresql://u@h:5/d");
  EXPECT_EQ(shown("a:b@c?.sqlite"), "a:b@c?.sqlite");
}

TEST(Database, OneOfANewerProgramIsRefused) {
  const Place place;
  Database(place).run(testing::on_postgres() ? "UPDATE enfilade_schema SET version = 99"
                                             : "PRAGMA user_version = 99");
  EXPECT_THAT(tests::refusal<FileError>([&place] { const Database again(place); }),
              HasSubstr("its schema has version 99"));
}

TEST(Database, AnotherFileIsRefusedAndLeftAsItWas) {
  EN_SKIP_ON_POSTGRES("there is no file");
  const tests::TemporaryFolder folder("database");
  const auto file = folder.path() / "a.sqlite";
  const std::string content(4096, 'x');
  write_file_atomically(file, content);
  EXPECT_THAT(tests::refusal<FileError>([&file] { const Database database(file); }),
              HasSubstr("not a usable database"));
  EXPECT_EQ(read_file(file), content);
}

/// A file of a folder as another program sees it.
struct SeenFile {
  std::string content;
  fs::perms rights{};
  fs::file_time_type written;
  friend bool operator==(const SeenFile&, const SeenFile&) = default;
};

std::map<std::string, SeenFile> files_in(const fs::path& folder) {
  std::map<std::string, SeenFile> all;
  for (const auto& one : fs::directory_iterator(folder)) {
    SeenFile& file = all[one.path().filename()];
    if (one.path().extension() == ".sqlite-shm") continue;  // its readers' marks may change
    file = {read_file(one.path()), one.status().permissions(), one.last_write_time()};
  }
  return all;
}

struct ForeignCase {
  const char* name;
  const char* made_by;  ///< SQL
  const char* named;    ///< in the message
  bool open = false;    ///< its program uses it, and has written nothing but its log
};

const std::array kForeign{
    ForeignCase{"a table", "CREATE TABLE mine (a)", "a table \"mine\""},
    ForeignCase{"names of ours", "CREATE TABLE team (a); CREATE TABLE token (a)", "\"team\""},
    ForeignCase{"a version too", "CREATE TABLE mine (a); PRAGMA user_version = 2", "\"mine\""},
    ForeignCase{"an id", "PRAGMA application_id = 7", "its application_id is 7"},
    ForeignCase{"a log", "PRAGMA journal_mode = WAL; CREATE TABLE mine (a)", "\"mine\""},
    ForeignCase{"all in a log", "PRAGMA journal_mode = WAL; CREATE TABLE mine (a)", "\"mine\"",
                true},
};

TEST(Database, AnotherProgramsDatabaseIsRefusedAndLeftAsItWas) {
  EN_SKIP_ON_POSTGRES("there is no file");
  for (const ForeignCase& one : kForeign) {
    SCOPED_TRACE(one.name);
    const tests::TemporaryFolder folder("database"), ours("database");
    const fs::path file = folder.path() / "what? #1 50%.sqlite", own = ours.path() / "a.sqlite";
    { const Database made(own); }
    std::optional<SQLite::Database> program(std::in_place, file.string(),
                                            SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
    program->exec(one.made_by);
    if (!one.open) program.reset();
    fs::permissions(file, fs::perms{0644});
    const auto before = files_in(folder.path());
    EXPECT_EQ(before.size(), one.open ? 3U : 1U);
    for (const std::function<void()>& use : std::initializer_list<std::function<void()>>{
             [&] { const Database database(file); },
             [&] { back_up(file, ours.path() / "copy.sqlite"); }, [&] { back_up(own, file); }}) {
      EXPECT_THAT(tests::refusal<FileError>(use),
                  AllOf(HasSubstr(file.string()), HasSubstr(one.named)));
      EXPECT_TRUE(files_in(folder.path()) == before);
    }
  }
}

TEST(Database, AnEmptyFileAndAnEmptyDatabaseAreNobodys) {
  EN_SKIP_ON_POSTGRES("there is no file");
  const tests::TemporaryFolder folder("database");
  const fs::path file = folder.path() / "a.sqlite", killed = folder.path() / "b.sqlite";
  write_file_atomically(file, "");
  SQLite::Database(killed.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE)
      .exec("PRAGMA journal_mode = WAL");  // as a kill at the first moment leaves it
  for (const fs::path& one : {file, killed}) {
    Database database(one);
    EXPECT_EQ(version_of(database), kNewest);
  }
}

// A copy of a file and its log, without the file by which processes share the log.
TEST(Database, OneOfOursIsFoundByItsLogAlone) {
  EN_SKIP_ON_POSTGRES("there is no file");
  const tests::TemporaryFolder folder("database"), other("database");
  {
    const Database open(folder.path() / "a.sqlite");
    for (const char* name : {"a.sqlite", "a.sqlite-wal"}) {
      fs::copy_file(folder.path() / name, other.path() / name);
    }
  }
  Database database(other.path() / "a.sqlite");
  EXPECT_EQ(version_of(database), kNewest);
}

TEST(Database, TablesOfAnotherProgramAreRefused) {
  if (!testing::on_postgres()) GTEST_SKIP() << "SQLite's files have an application id";
  const Place place;
  testing::run_sql(place, "CREATE TABLE other (a INTEGER)");
  { const Database shared(place); }
  const Place taken;
  testing::run_sql(taken, "CREATE TABLE team (a INTEGER)");
  EXPECT_THAT(tests::refusal<FileError>([&taken] { const Database database(taken); }),
              HasSubstr("another program has a table team"));
  EXPECT_THAT(connect(taken)->tables(), ElementsAre("team"));
}

TEST(Database, AMissingTableIsNamed) {
  for (const std::string& table : schema_tables()) {
    const Place place;
    { const Database made(place); }
    testing::run_sql(place, "DROP TABLE " + table + (testing::on_postgres() ? " CASCADE" : ""));
    EXPECT_THAT(tests::refusal<FileError>([&place] { const Database database(place); }),
                HasSubstr("its table " + table + " is missing"));
  }
}

// A server that is lost is told as such; what was not kept is not there in part, and the next
// statement connects again.
TEST(Database, ALostServerIsConnectedToAgain) {
  if (!testing::on_postgres()) GTEST_SKIP() << "SQLite has no server";
  const Place place;
  Database database(place);
  const std::string insert = "INSERT INTO team (name, contact, created) VALUES (?, '', 0)";
  database.run(insert, "kept");
  Health health(database, 1);
  EXPECT_EQ(health.trouble(), std::nullopt);
  const auto fails = [&database](const std::string& sql) {
    try {
      database.find_number(sql);
    } catch (const DatabaseError& error) {
      return error.cause() == DatabaseError::Cause::kUnreachable;
    }
    return false;
  };
  EXPECT_THROW(database.transact([&] {
    database.run(insert, "lost");
    testing::postgres_server().crash();
    EXPECT_TRUE(fails("SELECT count(*) FROM team"));
    EXPECT_TRUE(fails("SELECT count(*) FROM team"));  // no new connection in its middle
  }),
               DatabaseError);
  EXPECT_TRUE(fails("SELECT count(*) FROM team"));
  EXPECT_EQ(Health(database, 1).trouble(), Trouble::kDatabaseUnreachable);
  testing::postgres_server().start();
  std::this_thread::sleep_for(std::chrono::seconds(1));  // it is not asked by each request
  EXPECT_EQ(database.find_number("SELECT count(*) FROM team"), 1);
  database.run(insert, "again");
  EXPECT_EQ(Health(database, 1).trouble(), std::nullopt);
}

TEST(Database, WhatIsAcknowledgedIsOnTheDiskWhateverTheServersDefault) {
  if (!testing::on_postgres()) GTEST_SKIP() << "SQLite's is set, always";
  Database database(testing::postgres_server().make_database() +
                    "&options=-csynchronous_commit%3Doff");
  EXPECT_EQ(database.find<std::string>("SHOW synchronous_commit"), "on");
}

TEST(Database, ADatabaseOfAnotherEncodingIsRefused) {
  if (!testing::on_postgres()) GTEST_SKIP() << "SQLite's is UTF-8, always";
  const std::string place = testing::postgres_server().make_database(
      {"-E", "LATIN1", "-T", "template0", "--locale", "C"});
  EXPECT_THAT(tests::refusal<FileError>([&place] { const Database database(place); }),
              HasSubstr("its encoding is LATIN1"));
}

TEST(Database, ABackUpIsMadeWhileItIsOpen) {
  EN_SKIP_ON_POSTGRES("there is no file");
  const tests::TemporaryFolder folder("database");
  Database database(folder.path() / "a.sqlite");
  database.run("INSERT INTO team (name, contact, created) VALUES ('t', '', 0)");
  back_up(folder.path() / "a.sqlite", folder.path() / "copy.sqlite");
  back_up(folder.path() / "a.sqlite", folder.path() / "copy.sqlite");  // replaces the first
  Database copy(folder.path() / "copy.sqlite");
  EXPECT_EQ(copy.find<std::string>("SELECT name FROM team"), "t");
}

TEST(Database, ABackUpReplacesNoDatabaseInUse) {
  EN_SKIP_ON_POSTGRES("there is no file");
  const tests::TemporaryFolder folder("database");
  const std::filesystem::path file = folder.path() / "a.sqlite", other = folder.path() / "b.sqlite";
  { const Database made(file); }
  const auto refused = [&](const std::filesystem::path& copy) {
    return tests::refusal<FileError>([&] { back_up(file, copy); });
  };
  EXPECT_THAT(refused(file), HasSubstr("a.sqlite: a database in use, not a copy"));
  std::filesystem::create_symlink(file, folder.path() / "link.sqlite");
  EXPECT_THAT(refused(folder.path() / "link.sqlite"), HasSubstr("in use"));
  std::optional<Database> database(std::in_place, other);
  EXPECT_THAT(refused(other), HasSubstr("b.sqlite: a database in use, not a copy"));
  database.reset();
  EXPECT_EQ(refused(other), "accepted");
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
  EN_SKIP_ON_POSTGRES("there is no file");
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
  EN_SKIP_ON_POSTGRES("there is no file");
  const NoUmask no_umask;
  const tests::TemporaryFolder folder("database");
  const auto file = folder.path() / "a.sqlite";
  // As the first versions of Enfilade left it, with a log: killed while it was open.
  SQLite::Database old(file.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
  old.exec("PRAGMA journal_mode = WAL; PRAGMA user_version = 1");
  old.exec(kMigrations[0]);
  ASSERT_NE(rights_of(file), 0600U);
  Database database(file);
  for (const char* name : {"a.sqlite", "a.sqlite-wal", "a.sqlite-shm"}) {
    EXPECT_EQ(rights_of(folder.path() / name), 0600U) << name;
  }
}

TEST(Database, OneThatMayNotBeWrittenIsRefused) {
  EN_SKIP_ON_POSTGRES("there is no file");
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

}  // namespace EN_UNIT
}  // namespace enfilade::service::store
