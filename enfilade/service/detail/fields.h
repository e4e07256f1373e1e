/// \file  The fields of JSON objects that people write, read by name and checked.
#pragma once
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/detail/json.h"

namespace enfilade::service::detail {

/// How much of a wrong value a message quotes.
inline constexpr std::size_t kQuoted = 40;

using TextCheck = bool (*)(std::string_view);

/// A text; reports `code` unless check(text). \param allowed what check() allows, for the message
std::string read_text(json::Element element, const json::Path& path, TextCheck check,
                      std::string_view allowed, json::Faults& faults,
                      const char* code = "bad-text");

/// One object. Faults are reported to the list; what cannot be read is the least value, or "".
class Fields {
 public:
  using Names = std::initializer_list<std::string_view>;

  /// Reports required fields that are missing, and an element that is no object.
  /// \pre path and faults outlive *this
  Fields(json::Element element, const json::Path& path, json::Faults& faults, Names required,
         Names optional = {});

  bool complete() const { return complete_; }  ///< all required fields are there
  bool has(std::string_view name) const;
  json::Path path(std::string_view name) const { return {path_, name}; }

  // \pre has(name)
  json::Element operator[](std::string_view name) const;
  std::string text(std::string_view name, TextCheck check, std::string_view allowed,
                   const char* code = "bad-text") const;
  /// Reports "out-of-range", as number(). `otherwise` if the field is absent.
  int integer(std::string_view name, int least, int most, int otherwise) const;
  double number(std::string_view name, double least, double most) const;

 private:
  const std::optional<json::Element>& find(std::string_view name) const;

  const json::Path& path_;
  json::Faults& faults_;
  std::vector<json::Field> wanted_;
  std::vector<std::optional<json::Element>> found_;
  bool complete_ = false;
};

}  // namespace enfilade::service::detail
