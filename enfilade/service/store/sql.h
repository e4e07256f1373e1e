/// \file  A statement in a line.
#pragma once
#include <SQLiteCpp/SQLiteCpp.h>
#include <SQLiteCpp/VariadicBind.h>
#include <cstdint>
#include <string>

namespace enfilade::service::store {

/// SQLITE_CONSTRAINT_UNIQUE, as SQLite::Exception::getExtendedErrorCode() has it.
inline constexpr int kUniqueViolated = 2067;

template <class... Values>
void run(SQLite::Database& db, const std::string& query, const Values&... values) {
  SQLite::Statement statement(db, query);
  SQLite::bind(statement, values...);
  statement.exec();
}

/// The first column of the first row; 0 if there is no row.
template <class... Values>
std::int64_t find_number(SQLite::Database& db, const std::string& query, const Values&... values) {
  SQLite::Statement select(db, query);
  SQLite::bind(select, values...);
  return select.executeStep() ? select.getColumn(0).getInt64() : 0;
}

}  // namespace enfilade::service::store
