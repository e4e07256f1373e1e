/// \file  The fields of JSON objects that people write, read by name and checked. Faults are not
/// thrown: they are added to a json::Faults, whose owner throws them all at once.
#pragma once
#include <functional>
#include <initializer_list>
#include <limits>
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

/// For lists of any length.
inline constexpr std::size_t kAnyNumber = std::numeric_limits<std::size_t>::max();

/// The fields of one object. Its functions report faults to the constructor's list, and return a
/// substitute for unreadable values: "", or the least allowed number. An object of this class
/// belongs to one thread.
class Fields {
 public:
  using Names = std::initializer_list<std::string_view>;

  /// Finds the fields. Reports required ones that are missing, fields that are there twice, and an
  /// element that is no object. Ignores fields of other names, unless refuse_others() is called.
  /// \pre path, faults, the names and the document of `element` outlive *this
  Fields(json::Element element, const json::Path& path, json::Faults& faults, Names required,
         Names optional = {});

  /// Whether the element is an object that has all required fields, and none of the fields twice.
  bool complete() const { return complete_; }
  /// Reports fields of other names, as json::refuse_others(). False if it reported.
  bool refuse_others() const { return json::refuse_others(element_, wanted_, path_, faults_); }
  /// Whether the field is there, with whatever value. \pre, here and below: the name is one of
  /// those of the constructor
  bool has(std::string_view name) const;
  /// The field's path, for messages. It refers to the constructor's path and to `name`.
  json::Path path(std::string_view name) const { return {path_, name}; }

  /// The field's value. \pre has(name)
  json::Element operator[](std::string_view name) const;
  /// A text; "", reported, for any other element. With `code`, reports a text that check() does not
  /// allow (which is returned). \pre has(name)
  /// \param allowed the texts that check() allows, for the message: "1 to 40 of a-z, 0-9, - and _"
  std::string text(std::string_view name, TextCheck check, std::string_view allowed,
                   const char* code = "bad-text") const;
  /// Any text. \pre has(name)
  std::string string(std::string_view name) const;
  /// false if the field is absent
  bool boolean(std::string_view name) const;
  /// Reads a list, element by element, until the faults are full. Reports "too-many" after `most`.
  /// \param things what they are, for that message: " steps"  \pre has(name)
  void list(std::string_view name, std::size_t most, std::string_view things,
            const std::function<void(json::Element, const json::Path&)>& read) const;
  /// A list of texts, each as text() reads it. \pre has(name)
  std::vector<std::string> texts(std::string_view name, std::size_t most, TextCheck check,
                                 std::string_view allowed) const;
  /// A whole number. Reports "out-of-range" unless it is from `least` to `most`; the nearest
  /// allowed number is returned then. \returns `otherwise` if the field is absent
  int integer(std::string_view name, int least, int most, int otherwise) const;
  /// A number. Reports "out-of-range" unless it is from `least` to `most`; it is returned all the
  /// same. \pre has(name)
  double number(std::string_view name, double least, double most) const;

 private:
  const std::optional<json::Element>& find(std::string_view name) const;

  json::Element element_;
  const json::Path& path_;
  json::Faults& faults_;
  std::vector<json::Field> wanted_;
  std::vector<std::optional<json::Element>> found_;
  bool complete_ = false;
};

/// Limits of the JSON of requests. A body is bounded in bytes, levels and values before it is
/// parsed, and so is the memory that it takes. No request has more than seven levels.
inline constexpr std::size_t kMostLevels = 16;
/// Names, texts, choices: of routes that take up to 16 KiB.
inline constexpr json::Limits kFormLimits{1000, kMostLevels};
/// A worker's draft or trajectory: 5000 steps of four numbers and their names.
inline constexpr json::Limits kWorkLimits{60'000, kMostLevels};
/// A new collection: 100,000 paths with three instructions each, 23 values and keys per path.
inline constexpr json::Limits kCollectionLimits{2'500'000, kMostLevels};

/// Fields of other names in a body: programs send more than this version reads, people misspell.
enum class Others { kIgnored, kRefused };

/// Parses a request's body, an object, and reads it if it has all required fields, each once.
/// \param file its name in messages
/// \throws InvalidInput with all faults; "too-large" for a body beyond the limits
void read_body(std::string_view body, const char* file, const json::Limits& limits,
               Fields::Names required, Fields::Names optional,
               const std::function<void(const Fields&, json::Faults&)>& read,
               Others others = Others::kIgnored);

}  // namespace enfilade::service::detail
