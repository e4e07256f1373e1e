
#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/service/server.h"
#include "enfilade/service/store/database.h"
#include "tests/support/databases.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::service::store {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::HasSubstr;

// A row or two in every table, with what is hard to copy: a reference that goes round (item 1 is of
// task 1, which is of item 2), bytes that are no text, NULLs, numbers at their ends, ids that were
// given and are gone.
constexpr const char* kRows = R"sql(
INSERT INTO team (id, name, contact, created) VALUES (3, 'Ä team', 'a@b.c', 1), (7, 'b', '', 2);
INSERT INTO phase_rule (id, phase, rule, digest, goals, levels, means_bits) VALUES
  (4, 'p', 'r', 'd', x'00ff', 0, 0.5);
INSERT INTO submission (id, team, phase, method, created, state, digest, content, shown, near_copy_of, rule) VALUES
  (1, 3, 'p', 'm', 5, 'scored', 'd', x'00ff27225c0a00', 0.1, NULL, 4),
  (2, 7, 'p', '', 6, 'queued', '', x'', NULL, 1, NULL), (9, 7, 'p', '', 6, 'queued', '', x'', NULL, NULL, NULL);
DELETE FROM submission WHERE id = 9;
INSERT INTO collection (id, name, title, kind, open, link_key, platform, origins, completion_code, consent,
  instructions, per_item, lease_seconds, tasks_per_visit, created) VALUES
  (1, 'c', 'It''s "C"', 'write', 1, 'k', 'self', '', '', '', '', 1, 60, 0, 0);
INSERT INTO item (id, collection, split, path_id, number, scan, heading, path, instruction, secret, state)
  VALUES (1, 1, 'train', 9223372036854775807, 0, 's', 1e-300, 'a
b', '', 0, 'fresh'), (2, 1, 'train', -1, 0, 's', 0.1, '', 'line
two', 1, 'begun');
INSERT INTO worker (id, collection, external, created) VALUES (5, 1, 'w', 0);
INSERT INTO visit (id, worker, external, grouped, submit_to, created) VALUES (4, 5, 'v', '', '', 0);
INSERT INTO task (id, item, worker, visit, state, expires) VALUES (1, 2, 5, 4, 'accepted', 0);
UPDATE item SET of = 1 WHERE id = 1;
INSERT INTO event (task, at, who, what, before, reason) VALUES (1, 0, 'r', 'accepted', '', '');
INSERT INTO token (hash, role, team, label, created) VALUES ('h', 'team', 3, 'l', 0);
INSERT INTO session (hash, token, expires) VALUES ('s', 1, 99);
INSERT INTO attempt (team, phase, address, created, submission) VALUES (3, 'p', 'x', 0, 2);
INSERT INTO phase_end VALUES ('p', 1);
INSERT INTO secret VALUES ('n', 'v');
INSERT INTO question (collection, stage, text, choices, accepted) VALUES (1, 'check', '?', 'a', 'a');
INSERT INTO answer VALUES (1, 5, 'a', 1, 0);
INSERT INTO dialogue (item, navigator) VALUES (2, 1);
INSERT INTO turn (dialogue, role, text, viewpoint, heading, elevation, at) VALUES (1, 'oracle', '', '', 0, 0, 0);
INSERT INTO play (hash, task, split, episode, steps, mistakes, touched) VALUES ('', 'r2r', 's', 'e', 1, 1, 0);
INSERT INTO play_call VALUES (1, 0, 'look', '', ''), (1, 1, 'go_to', 'B', '');
)sql";

struct NamedColumn {
  std::string name;
  bool real = false;  ///< of which the databases write 0.0 and 0
};

/// All rows of a table, each as one text; of a database of either kind.
std::vector<std::string> rows_of(Connection& connection, const std::string& table,
                                 const std::vector<NamedColumn>& columns) {
  std::string names;
  for (const NamedColumn& column : columns) {
    names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", column.name);
  }
  std::vector<std::string> found;
  for (const auto rows = connection.select(
           fmt::format("SELECT {} FROM \"{}\" ORDER BY {}", names, table, names), {});
       rows->next();) {
    std::string& row = found.emplace_back();
    for (int k = 0; k < rows->columns(); ++k) {
      const bool real = columns[static_cast<std::size_t>(k)].real;
      row += rows->is_null(k) ? "NULL" : real ? fmt::format("{}", rows->real(k)) : rows->text(k);
      row += '|';
    }
  }
  return found;
}

class TransferTest : public ::testing::Test {
 protected:
  TransferTest() {
    static_cast<void>(Database{file_});
    SQLite::Database(file_, SQLite::OPEN_READWRITE).exec(kRows);
  }

  tests::TemporaryFolder folder_{"transfer"};
  std::string file_ = folder_.path() / "a.sqlite";
};

TEST_F(TransferTest, EveryRowOfEveryTableIsThere) {
  if (!testing::on_postgres()) GTEST_SKIP() << "with ENFILADE_TEST_DATABASE=postgres";
  const std::string url = testing::postgres_server().make_schema();
  std::size_t told = 0;
  const std::int64_t rows =
      transfer(file_, url, [&told](std::size_t done, std::size_t /*total*/) { told = done; });
  EXPECT_EQ(rows, 24);
  EXPECT_EQ(told, 24U);
  const auto from = connect(file_), to = connect(url);
  SQLite::Database file(file_);
  SQLite::Statement tables(
      file, "SELECT name FROM sqlite_schema WHERE type = 'table' AND name NOT LIKE 'sqlite_%'");
  int filled = 0;
  while (tables.executeStep()) {
    const std::string table = tables.getColumn(0);
    std::vector<NamedColumn> columns;
    SQLite::Statement names(file,
                            "SELECT name, type = 'REAL' FROM pragma_table_info('" + table + "')");
    while (names.executeStep()) {
      columns.push_back({names.getColumn(0).getString(), names.getColumn(1).getInt() == 1});
    }
    const auto expected = rows_of(*from, table, columns);
    EXPECT_FALSE(expected.empty()) << table << ": give it a row above";
    EXPECT_EQ(rows_of(*to, table, columns), expected) << table;
    ++filled;
  }
  EXPECT_EQ(filled, 20);
  // New rows have ids that nobody has had: 9 was given, and is gone.
  Database database(url);
  EXPECT_EQ(database.insert("INSERT INTO submission (team, phase, method, created, state, digest, "
                            "content) VALUES (3, 'p', '', 0, 'queued', '', ?)",
                            Blob{"x"}),
            10);
  EXPECT_EQ(database.insert("INSERT INTO team (name, contact, created) VALUES ('c', '', 0)"), 8);
}

TEST_F(TransferTest, ADatabaseThatHasRowsIsRefusedAndStays) {
  if (!testing::on_postgres()) GTEST_SKIP() << "with ENFILADE_TEST_DATABASE=postgres";
  const std::string url = testing::postgres_server().make_schema();
  { Database(url).run("INSERT INTO secret (name, value) VALUES ('own', 'value')"); }
  EXPECT_THAT(tests::refusal<FileError>([&] { transfer(file_, url, {}); }),
              HasSubstr("its table secret has rows"));
  Database database(url);
  EXPECT_EQ(database.find_number("SELECT count(*) FROM secret"), 1);
  EXPECT_EQ(database.find_number("SELECT count(*) FROM team"), 0);
}

// A text with a NUL is none in PostgreSQL: nothing is copied, and the row is named.
TEST_F(TransferTest, ARowThatCannotBeKeptIsNamedAndNothingIsCopied) {
  if (!testing::on_postgres()) GTEST_SKIP() << "with ENFILADE_TEST_DATABASE=postgres";
  SQLite::Database(file_, SQLite::OPEN_READWRITE)
      .exec("INSERT INTO secret VALUES ('nul', CAST(x'6100' AS TEXT))");
  const std::string url = testing::postgres_server().make_schema();
  EXPECT_THAT(tests::refusal<Error>([&] { transfer(file_, url, {}); }),
              AllOf(HasSubstr("table secret, row nul"), HasSubstr("NUL")));
  EXPECT_EQ(Database(url).find_number("SELECT count(*) FROM team"), 0);
}

TEST_F(TransferTest, OtherPlacesAreRefused) {
  EXPECT_THAT(tests::refusal<ArgumentError>(
                  [&] { copy_to_postgres(file_, folder_.path() / "b.sqlite", {}); }),
              AllOf(HasSubstr("b.sqlite"), HasSubstr("postgresql://USER@HOST/NAME")));
  EXPECT_THAT(tests::refusal<ArgumentError>(
                  [&] { copy_to_postgres("postgresql://a@b/c", "postgresql://a@b/d", {}); }),
              HasSubstr("a file is copied, not a database"));
  EXPECT_THAT(tests::refusal<FileError>([&] {
                copy_to_postgres(folder_.path() / "none.sqlite", "postgresql://a@b/c", {});
              }),
              HasSubstr("none.sqlite"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::service::store
