/// \file  Reading of JSON files, with exact positions of faults. Internal, as it includes simdjson.
#pragma once
#include <simdjson.h>
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"

namespace enfilade::json {

using Element = simdjson::dom::element;

/// JSON path of a value, a linked list on the stack; becomes a text only when a fault is reported.
class Path {
 public:
  Path() = default;
  Path(const Path& parent, std::string_view key) : parent_(&parent), key_(key) {}
  Path(const Path& parent, std::size_t index) : parent_(&parent), index_(index) {}
  std::string text() const;  ///< "$[3].trajectory[0]"

 private:
  const Path* parent_ = nullptr;
  std::string_view key_;
  std::size_t index_ = 0;
};

/// Collects the faults of one file: the first kMostFaultsKept errors, and as many warnings and
/// notes. Further ones are counted, so that memory stays bounded for any file.
class Faults {
 public:
  explicit Faults(std::string file) : file_(std::move(file)) {}

  void add(Severity severity, const Path& path, std::string code, std::string message);
  /// One that was found elsewhere, as it is.
  void add(Diagnostic found);
  void error(const Path& path, std::string code, std::string message) {
    add(Severity::kError, path, std::move(code), std::move(message));
  }
  /// Appends the faults of a part of the file that was read separately.
  void append(Faults part);
  const std::string& file() const noexcept { return file_; }
  std::size_t errors() const noexcept { return errors_; }  ///< also those that are only counted
  /// Whether further errors are only counted. A reader of long lists then calls stop(), and stops.
  bool full() const noexcept { return errors_ >= kMostFaultsKept; }
  /// Notes that the file is not read from `path` on, so that the number of errors is not known.
  /// Only the first call counts.
  void stop(const Path& path);
  bool stopped() const noexcept { return !stopped_at_.empty(); }
  /// The faults, in the order found. If there were more than are kept, a last diagnostic for the
  /// errors, and one for the rest, gives the number. *This is empty afterwards.
  std::vector<Diagnostic> take();
  /// \throws InvalidInput if there are errors.
  void throw_if_errors();

 private:
  std::string file_;
  std::vector<Diagnostic> diagnostics_;
  std::size_t errors_ = 0, others_ = 0;
  std::string stopped_at_;  // empty: nowhere
};

/// A parsed document. Elements and the strings in them are valid as long as it is.
class Document {
 public:
  /// \throws FileError if the file cannot be read; InvalidInput, with JSON path, line and column,
  /// if it is not JSON.
  static Document load(const std::filesystem::path& path);
  static Document parse(std::string_view text, const std::string& name);

  Element root() const { return root_; }
  const std::string& name() const noexcept { return name_; }

 private:
  Document(std::string_view text, std::string name);

  std::string name_;
  std::unique_ptr<simdjson::dom::parser> parser_;
  Element root_;
};

/// Checks in one pass that a text is JSON. Takes memory only for its deepest nesting and its
/// longest string. \throws InvalidInput as Document::parse(), also for more than 1024 levels
void check_syntax(std::string_view text, const std::string& name);
/// The error of Document::parse() for a text that simdjson refused with `code`.
InvalidInput not_json(std::string_view text, const std::string& name, simdjson::error_code code);
/// The position after a string of a JSON text; the text's end if the string does not end.
/// \param at the position after its first quotation mark
std::size_t skip_string(std::string_view text, std::size_t at);

/// Limits of a text's content. They bound the memory of a parsed text, which its length does not:
/// `[[],[],...]` takes 9 times its bytes in simdjson, and 20 times in nlohmann's library.
struct Limits {
  std::size_t values = 0;  ///< values and keys; an empty array or object counts as two
  std::size_t depth = 0;   ///< arrays and objects within each other
  /// In one object; 0: any number. nlohmann's ordered objects compare a new key with all others.
  std::size_t keys = 0;
};
/// "more than 1000 values and keys", "more than 16 levels", "an object of more than 100 keys";
/// empty for a text within its limits. Does not check that it is JSON. Takes memory for the levels
/// alone, and only if `keys` is a limit.
std::string excess(std::string_view text, const Limits& limits);

/// "number 4.5", "string \"abc\"", "array of 3": the value found, for messages.
std::string describe(Element element);

// Each gives the value, or reports "<what was found>, not <what was allowed>" and gives nothing.
std::optional<double> number(Element element, const Path& path, Faults& faults);
/// Radians, at most kMostRadians either way, else the fault `bad-angle`.
std::optional<double> angle(Element element, const Path& path, Faults& faults);
std::optional<std::int64_t> integer(Element element, const Path& path, Faults& faults);
std::optional<bool> boolean(Element element, const Path& path, Faults& faults);
std::optional<std::string_view> string(Element element, const Path& path, Faults& faults);
/// A string that is an id (core/names.h), else the fault `bad-id`. The one way in which readers of
/// JSON read ids of scans, viewpoints, instructions, objects and phases.
std::optional<std::string_view> id(Element element, const Path& path, Faults& faults,
                                   std::size_t most = kLongestId);
std::optional<simdjson::dom::array> array(Element element, const Path& path, Faults& faults);
std::optional<simdjson::dom::object> object(Element element, const Path& path, Faults& faults);
/// An array of strings; an element that is not a string is reported, and becomes "".
std::vector<std::string> strings(Element element, const Path& path, Faults& faults);
/// The same for ids.
std::vector<std::string> ids(Element element, const Path& path, Faults& faults);

/// A field that fields() looks for.
struct Field {
  std::string_view name;
  bool required = true;
};

/// The named fields of an object, in the order of `wanted`; empty where absent. Reports a missing
/// required field and a repeated one; ignores fields of other names. False if it reported.
bool fields(Element element, std::span<const Field> wanted, std::span<std::optional<Element>> found,
            const Path& path, Faults& faults);
/// The same for one field.
std::optional<Element> field(Element element, Field wanted, const Path& path, Faults& faults);
/// For files that people write: reports each field of an object that is not in `allowed`, as
/// "unknown-field" with the nearest allowed name. False if it reported. Not an object: true.
bool refuse_others(Element element, std::span<const Field> allowed, const Path& path,
                   Faults& faults);

}  // namespace enfilade::json
