/// \file  Values of C++ into statements of SQL, and rows back into values.
#pragma once
#include <SQLiteCpp/SQLiteCpp.h>
#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/service/detail/names.h"

namespace enfilade::service::store {

/// Bytes for a column of type BLOB.
struct Blob {
  std::string_view bytes;
};

/// How a list is stored: an entry a line. \pre no entry is empty or has a line break
std::string join_lines(const std::vector<std::string>& lines);
std::vector<std::string> split_lines(std::string_view text);

template <class T>
void bind(SQLite::Statement& statement, int k, const T& value) {
  if constexpr (std::integral<T>) {
    statement.bind(k, static_cast<std::int64_t>(value));
  } else if constexpr (std::floating_point<T>) {
    statement.bind(k, static_cast<double>(value));
  } else if constexpr (detail::Named<T>) {
    statement.bind(k, std::string(detail::name_of(value)));
  } else {
    statement.bind(k, std::string(value));
  }
}
/// None is NULL.
template <class T>
void bind(SQLite::Statement& statement, int k, const std::optional<T>& value) {
  value ? bind(statement, k, *value) : statement.bind(k);
}
inline void bind(SQLite::Statement& statement, int k, const std::vector<std::string>& lines) {
  statement.bind(k, join_lines(lines));
}
inline void bind(SQLite::Statement& statement, int k, const Blob& blob) {
  statement.bind(k, blob.bytes.data(), static_cast<int>(blob.bytes.size()));
}

/// The columns of a row, read from left to right: `row >> id >> name`. A type of several columns
/// has an operator>> of its own.
class Row {
 public:
  explicit Row(SQLite::Statement& statement) : statement_(statement) {}

  template <std::integral T>
  Row& operator>>(T& value) {
    value = static_cast<T>(next().getInt64());
    return *this;
  }
  template <detail::Named T>
  Row& operator>>(T& value) {
    const auto found = detail::find_named<T>(next().getString());
    if (!found) throw Error("the database has a name that this program does not know");
    value = *found;
    return *this;
  }
  template <class T>
  Row& operator>>(std::optional<T>& value) {
    value.reset();
    if (!statement_.getColumn(column_).isNull()) return *this >> value.emplace();
    ++column_;
    return *this;
  }
  template <class... T>
  Row& operator>>(std::tuple<T...>& values) {
    std::apply([this](T&... value) { (*this >> ... >> value); }, values);
    return *this;
  }
  Row& operator>>(double& value) {
    value = next().getDouble();
    return *this;
  }
  Row& operator>>(std::string& value) {
    value = next().getString();
    return *this;
  }
  Row& operator>>(std::vector<std::string>& lines) {
    lines = split_lines(next().getString());
    return *this;
  }

 private:
  SQLite::Column next() { return statement_.getColumn(column_++); }

  SQLite::Statement& statement_;
  int column_ = 0;
};

}  // namespace enfilade::service::store
