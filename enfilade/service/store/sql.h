/// \file  C++ values as parameters of SQL statements and as columns of their rows.
#pragma once
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
#include "enfilade/service/store/connection.h"

namespace enfilade::service::store {

/// Bytes for a column of type BLOB.
struct Blob {
  std::string_view bytes;
};

/// How a list is stored: one entry per line. \pre no entry is empty or has a line break
std::string join_lines(const std::vector<std::string>& lines);
std::vector<std::string> split_lines(std::string_view text);

/// A C++ value for a statement.
template <class T>
struct ToParameter {
  static constexpr Parameter::Type kType = std::integral<T>         ? Parameter::Type::kInteger
                                           : std::floating_point<T> ? Parameter::Type::kReal
                                           : std::same_as<T, Blob>  ? Parameter::Type::kBytes
                                                                    : Parameter::Type::kText;

  static Parameter of(const T& value) {
    if constexpr (std::integral<T>) {
      return {kType, static_cast<std::int64_t>(value)};
    } else if constexpr (std::floating_point<T>) {
      return {kType, static_cast<double>(value)};
    } else if constexpr (NamedEnum<T>) {
      return {kType, std::string(enum_name(value))};
    } else if constexpr (std::same_as<T, std::vector<std::string>>) {
      return {kType, join_lines(value)};
    } else if constexpr (std::same_as<T, Blob>) {
      return {kType, value.bytes};
    } else {
      return {kType, std::string(value)};
    }
  }
};
/// None is NULL.
template <class T>
struct ToParameter<std::optional<T>> {
  static Parameter of(const std::optional<T>& value) {
    return value ? ToParameter<T>::of(*value) : Parameter{ToParameter<T>::kType};
  }
};

/// The columns of a row, read from left to right. A struct has `auto columns()`, which gives
/// std::tie() of its fields in the order of the columns.
class Row {
 public:
  explicit Row(const Rows& rows) : rows_(rows) {}

  /// read(), for a T that all columns belong to.
  template <class T>
  void read_whole(T& value) {
    read(value);
    EN_CHECK_EQ(column_, rows_.columns());
  }

  template <class T>
  void read(T& value) {
    if constexpr (requires { value.columns(); }) {
      auto fields = value.columns();
      read(fields);
    } else if constexpr (std::integral<T>) {
      value = static_cast<T>(rows_.integer(column_++));
    } else if constexpr (std::floating_point<T>) {
      value = rows_.real(column_++);
    } else if constexpr (NamedEnum<T>) {
      const auto found = find_enum<T>(rows_.text(column_++));
      if (!found) throw Error("the database has a name that this program does not know");
      value = *found;
    } else if constexpr (std::same_as<T, std::vector<std::string>>) {
      value = split_lines(rows_.text(column_++));
    } else {
      value = rows_.text(column_++);
    }
  }
  template <class T>
  void read(std::optional<T>& value) {
    value.reset();
    if (rows_.is_null(column_)) {
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
  const Rows& rows_;
  int column_ = 0;
};

}  // namespace enfilade::service::store
