/// \file  Reading of JSON files, with exact places of faults. Internal, as it includes simdjson.
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

/// Collects what is wrong with one file.
class Faults {
 public:
  explicit Faults(std::string file) : file_(std::move(file)) {}

  void add(Severity severity, const Path& path, std::string code, std::string message);
  void error(const Path& path, std::string code, std::string message) {
    add(Severity::kError, path, std::move(code), std::move(message));
  }
  const std::string& file() const noexcept { return file_; }
  std::size_t errors() const noexcept { return errors_; }
  std::vector<Diagnostic> take() { return std::move(diagnostics_); }
  /// \throws InvalidInput if there are errors.
  void throw_if_errors();

 private:
  std::string file_;
  std::vector<Diagnostic> diagnostics_;
  std::size_t errors_ = 0;
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

/// "number 4.5", "string \"abc\"", "array of 3": what was found, for messages.
std::string describe(Element element);

// Each gives the value, or reports "<what was found>, not <what was allowed>" and gives nothing.
std::optional<double> number(Element element, const Path& path, Faults& faults);
std::optional<std::int64_t> integer(Element element, const Path& path, Faults& faults);
std::optional<bool> boolean(Element element, const Path& path, Faults& faults);
std::optional<std::string_view> string(Element element, const Path& path, Faults& faults);
std::optional<simdjson::dom::array> array(Element element, const Path& path, Faults& faults);
std::optional<simdjson::dom::object> object(Element element, const Path& path, Faults& faults);
/// An array of strings; "" stands for an element that is none, which is reported.
std::vector<std::string> strings(Element element, const Path& path, Faults& faults);

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

}  // namespace enfilade::json
