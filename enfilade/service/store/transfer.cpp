
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/service/store/database.h"

namespace enfilade::service::store {
namespace {

using Type = Parameter::ValueType;

struct Column {
  std::string name;
  Type type = Type::kText;
  /// It refers to rows that are copied later, so that it is set when all are there.
  bool later = false;
};

struct Table {
  std::string name;
  std::vector<Column> columns;
  std::int64_t rows = 0;
  std::int64_t largest_id = 0;  ///< that was ever given; 0: none
};

/// A column that is set when all rows are there.
struct Reference {
  const Table* table;
  std::string column;
  std::int64_t id, value;
};

std::string sql_name(std::string_view name) { return fmt::format("\"{}\"", name); }

Type type_of(const std::string& declared) {
  constexpr std::array<std::pair<std::string_view, Type>, 4> kTypes{{{"INTEGER", Type::kInteger},
                                                                     {"REAL", Type::kReal},
                                                                     {"TEXT", Type::kText},
                                                                     {"BLOB", Type::kBytes}}};
  for (const auto& [name, type] : kTypes) {
    if (declared == name) return type;
  }
  throw Error(fmt::format("a column of type {}, which is not copied", declared));
}

Parameter text(std::string_view value) { return {Type::kText, std::string(value)}; }

std::int64_t number(Connection& connection, const std::string& sql,
                    std::span<const Parameter> values = {}) {
  const auto rows = connection.select(sql, values);
  return rows->next() ? rows->integer(0) : 0;
}

/// In the order in which they were made: those that others refer to come first.
std::vector<Table> tables_of(Connection& file) {
  std::vector<Table> tables;
  for (const auto rows = file.select(
           "SELECT name FROM sqlite_schema WHERE type = 'table' AND name NOT LIKE 'sqlite_%' "
           "ORDER BY rowid",
           {});
       rows->next();) {
    tables.emplace_back().name = rows->text(0);
  }
  std::set<std::string> before;
  for (Table& table : tables) {
    const std::array named{text(table.name)};
    for (const auto rows = file.select("SELECT name, type FROM pragma_table_info(?)", named);
         rows->next();) {
      table.columns.push_back({rows->text(0), type_of(rows->text(1))});
    }
    for (const auto rows =
             file.select("SELECT \"from\", \"table\" FROM pragma_foreign_key_list(?)", named);
         rows->next();) {
      const auto column = std::ranges::find(table.columns, rows->text(0), &Column::name);
      if (column != table.columns.end()) column->later = !before.contains(rows->text(1));
    }
    before.insert(table.name);
    table.rows = number(file, fmt::format("SELECT count(*) FROM {}", sql_name(table.name)));
    if (table.rows > 0 && table.columns.front().name == "id") {
      table.largest_id =
          std::max(number(file, fmt::format("SELECT max(id) FROM {}", sql_name(table.name))),
                   number(file, "SELECT seq FROM sqlite_sequence WHERE name = ?", named));
    }
  }
  return tables;
}

Parameter value_of(const ResultSet& row, int k, Type type, std::string& bytes) {
  if (row.is_null(k)) return {type};
  if (type == Type::kInteger) return {type, row.integer(k)};
  if (type == Type::kReal) return {type, row.real(k)};
  if (type == Type::kText) return {type, row.text(k)};
  bytes = row.text(k);
  return {type, std::string_view(bytes)};
}

class Transfer {
 public:
  Transfer(Connection& from, Connection& to, const Progress& progress)
      : from_(from), to_(to), progress_(progress), tables_(tables_of(from)) {
    for (const Table& table : tables_) total_ += table.rows;
  }

  std::int64_t run(const std::string& shown) {
    for (const Table& table : tables_) {
      if (number(to_, fmt::format("SELECT count(*) FROM {}", sql_name(table.name))) == 0) continue;
      throw FileError(
          fmt::format("{}: its table {} has rows; a file is copied into a database that no server "
                      "has used",
                      shown, table.name));
    }
    for (const Table& table : tables_) copy(table);
    for (const Reference& one : references_) {
      const std::array values{Parameter{Type::kInteger, one.value},
                              Parameter{Type::kInteger, one.id}};
      to_.run(fmt::format("UPDATE {} SET {} = ? WHERE id = ?", sql_name(one.table->name),
                          sql_name(one.column)),
              values);
    }
    return total_;
  }

 private:
  void copy(const Table& table) {
    std::vector<std::string> names;
    for (const Column& column : table.columns) names.push_back(sql_name(column.name));
    const std::string columns = fmt::format("{}", fmt::join(names, ", "));
    const std::string insert =
        fmt::format("INSERT INTO {} ({}) VALUES ({})", sql_name(table.name), columns,
                    fmt::join(std::vector<std::string_view>(names.size(), "?"), ", "));
    const auto rows =
        from_.select(fmt::format("SELECT {} FROM {}", columns, sql_name(table.name)), {});
    std::vector<Parameter> values(names.size());
    std::vector<std::string> bytes(names.size());
    while (rows->next()) {
      for (std::size_t k = 0; k < names.size(); ++k) {
        const Column& column = table.columns[k];
        values[k] = value_of(*rows, static_cast<int>(k), column.type, bytes[k]);
        const auto* refers = std::get_if<std::int64_t>(&values[k].value);
        if (!column.later || refers == nullptr) continue;
        references_.push_back({&table, column.name, rows->integer(0), *refers});
        values[k] = {column.type};
      }
      try {
        to_.run(insert, values);
      } catch (const DatabaseError& error) {
        if (error.cause() == DatabaseError::Cause::kUnreachable) throw;
        throw Error(fmt::format("table {}, row {}: {}", table.name, rows->text(0), error.what()));
      }
      if (progress_) progress_(++done_, static_cast<std::size_t>(total_));
    }
    if (table.largest_id == 0) return;
    const std::array last{text(sql_name(table.name)), Parameter{Type::kInteger, table.largest_id}};
    number(to_, "SELECT setval(pg_get_serial_sequence(?, 'id'), ?)", last);
  }

  Connection& from_;
  Connection& to_;
  const Progress& progress_;
  std::vector<Table> tables_;
  std::vector<Reference> references_;
  std::size_t done_ = 0;
  std::int64_t total_ = 0;
};

}  // namespace

std::int64_t transfer(const std::string& file, const std::string& url, const Progress& progress) {
  Database from(file), to(url);
  try {
    return from.transact([&] {  // so that no other client changes it
      return to.transact([&] {
        return Transfer(from.connection(), to.connection(), progress).run(to.shown_place());
      });
    });
  } catch (const DatabaseError& error) {
    throw FileError(
        fmt::format("{} into {}: {}", from.shown_place(), to.shown_place(), error.what()));
  }
}

}  // namespace enfilade::service::store
