/// \file  The fields of JSON objects that people write, read by name and checked. Faults are not
/// thrown: they are added to a json::Faults, whose owner throws them all at once.
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

/// Whether a text is allowed.
using TextCheck = bool (*)(std::string_view);

/// Reads a text. Reports an element that is not a text ("" is returned then). With `code`, reports
/// a text that check() does not allow (which is returned).
/// \param allowed the texts that check() allows, for the message: "1 to 40 of a-z, 0-9, - and _"
std::string read_text(json::Element element, const json::Path& path, TextCheck check,
                      std::string_view allowed, json::Faults& faults,
                      const char* code = "bad-text");

/// The fields of one object. Its functions report faults to the constructor's list, and return a
/// substitute for unreadable values: "", or the least allowed number. An object of this class
/// belongs to one thread.
class Fields {
 public:
  using Names = std::initializer_list<std::string_view>;

  /// Finds the fields. Reports required ones that are missing, fields that are there twice, and an
  /// element that is no object; ignores fields of other names.
  /// \pre path, faults, the names and the document of `element` outlive *this
  Fields(json::Element element, const json::Path& path, json::Faults& faults, Names required,
         Names optional = {});

  /// Whether the element is an object that has all required fields, and none of the fields twice.
  bool complete() const { return complete_; }
  /// Whether the field is there, with whatever value. \pre, here and below: the name is one of
  /// those of the constructor
  bool has(std::string_view name) const;
  /// The field's path, for messages. It refers to the constructor's path and to `name`.
  json::Path path(std::string_view name) const { return {path_, name}; }

  /// The field's value. \pre has(name)
  json::Element operator[](std::string_view name) const;
  /// The field as read_text() reads it. \pre has(name)
  std::string text(std::string_view name, TextCheck check, std::string_view allowed,
                   const char* code = "bad-text") const;
  /// A whole number. Reports "out-of-range" unless it is from `least` to `most`; the nearest
  /// allowed number is returned then. \returns `otherwise` if the field is absent
  int integer(std::string_view name, int least, int most, int otherwise) const;
  /// A number. Reports "out-of-range" unless it is from `least` to `most`; it is returned all the
  /// same. \pre has(name)
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
