/// \file  C++ values as parameters of SQL statements and as columns of their rows.
#pragma once
#include <SQLiteCpp/SQLiteCpp.h>
#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/errors.h"

namespace enfilade::service::store {

/// Bytes for a column of type BLOB.
struct Blob {
  std::string_view bytes;
};

/// How a list is stored: an entry a line. \pre no entry is empty or has a line break
std::string join_lines(const std::vector<std::string>& lines);
std::vector<std::string> split_lines(std::string_view text);

/// Binds a value to question mark k.
template <class T>
void bind(SQLite::Statement& statement, int k, const T& value) {
  if constexpr (std::integral<T>) {
    statement.bind(k, static_cast<std::int64_t>(value));
  } else if constexpr (std::floating_point<T>) {
    statement.bind(k, static_cast<double>(value));
  } else if constexpr (NamedEnum<T>) {
    statement.bind(k, std::string(enum_name(value)));
  } else if constexpr (std::same_as<T, std::vector<std::string>>) {
    statement.bind(k, join_lines(value));
  } else if constexpr (std::same_as<T, Blob>) {
    statement.bind(k, value.bytes.data(), static_cast<int>(value.bytes.size()));
  } else {
    statement.bind(k, std::string(value));
  }
}
/// None is NULL.
template <class T>
void bind(SQLite::Statement& statement, int k, const std::optional<T>& value) {
  value ? bind(statement, k, *value) : statement.bind(k);
}

/// The columns of a row, read from left to right. A struct has `auto columns()`, which gives
/// std::tie() of its fields in the order of the columns.
class Row {
 public:
  explicit Row(SQLite::Statement& statement) : statement_(statement) {}

  /// read(), for a T that all columns belong to.
  template <class T>
  void read_whole(T& value) {
    read(value);
    EN_CHECK_EQ(column_, statement_.getColumnCount());
  }

  template <class T>
  void read(T& value) {
    if constexpr (requires { value.columns(); }) {
      auto fields = value.columns();
      read(fields);
    } else if constexpr (std::integral<T>) {
      value = static_cast<T>(next().getInt64());
    } else if constexpr (std::floating_point<T>) {
      value = next().getDouble();
    } else if constexpr (NamedEnum<T>) {
      const auto found = find_enum<T>(next().getString());
      if (!found) throw Error("the database has a name that this program does not know");
      value = *found;
    } else if constexpr (std::same_as<T, std::vector<std::string>>) {
      value = split_lines(next().getString());
    } else {
      value = next().getString();
    }
  }
  template <class T>
  void read(std::optional<T>& value) {
    value.reset();
    if (statement_.isColumnNull(column_)) {
      ++column_;
    } else {
      read(value.emplace());
    }
  }
  template <class... T>
  void read(std::tuple<T...>& values) {
    std::apply([this](auto&... value) { (this->read(value), ...); }, values);
  }

 private:
  SQLite::Column next() { return statement_.getColumn(column_++); }

  SQLite::Statement& statement_;
  int column_ = 0;
};

}  // namespace enfilade::service::store
