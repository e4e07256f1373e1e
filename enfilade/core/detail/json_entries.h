/// \file  Reading of a large JSON list, one entry at a time, and of a large object, one member at a
/// time. Internal, as it includes simdjson.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/detail/json.h"

namespace enfilade::json {

/// Iterates over the entries of a text that is one list. Only one entry is parsed at a time, so
/// memory beside the text is that of the largest parsed entry: up to 14 times its bytes. Accepts
/// and refuses the same texts as Document::parse(), with the same messages.
///
///     Entries entries(text, "results.json", most_bytes);
///     if (!entries.is_list(faults)) return;
///     while (entries.next()) {
///       if (entries.element()) read(*entries.element(), Path(root, entries.index()));
///     }
///
/// Belongs to one thread.
class Entries {
 public:
  /// \param most_bytes  of an entry that is parsed
  /// \pre the text outlives *this
  Entries(std::string_view text, std::string name, std::size_t most_bytes);
  Entries(const Entries&) = delete;
  Entries& operator=(const Entries&) = delete;

  /// Whether the text is a list. If not, that is reported to `faults`, at $.
  /// \throws InvalidInput for a text that is not JSON, and no list either
  bool is_list(Faults& faults);
  /// Goes to the next entry. False if there are no more. The whole text is JSON then; entries that
  /// are too large were checked only for brackets and strings.
  /// \pre is_list()
  /// \throws InvalidInput if the text is not JSON as far as this entry
  bool next();
  std::size_t index() const noexcept { return index_; }  ///< index of the entry \pre next()
  std::size_t bytes() const noexcept { return bytes_; }  ///< bytes of the entry \pre next()
  /// Valid until the next call of next(); none if the entry has more than `most_bytes`. \pre next()
  const std::optional<Element>& element() const noexcept { return element_; }

 private:
  bool take_plain_object(std::size_t begin);
  void take_any(std::size_t begin);
  simdjson::error_code parse(std::size_t begin, std::size_t end);
  void skip_blanks();
  [[noreturn]] void refuse(simdjson::error_code code) const;

  std::string_view text_;
  std::string name_;
  std::size_t most_bytes_;
  std::size_t at_ = 0;
  std::size_t index_;
  std::size_t bytes_ = 0;
  bool plain_ = true;  // all entries until now were plain objects
  std::optional<Element> element_;
  simdjson::dom::parser parser_;
};

/// Iterates over the members of a text that is one object, repeated ones too. A value is parsed
/// only on request, so that Entries can read a large one. If every value is parsed, the same texts
/// are accepted and refused as by Document::parse(), with the same messages.
///
///     Members members(text, "walks.json");
///     if (!members.is_object(faults)) return;
///     while (members.next()) read(members.key(), members.element(most_bytes));
///
/// Belongs to one thread.
class Members {
 public:
  /// \pre the text outlives *this
  Members(std::string_view text, std::string name);
  Members(const Members&) = delete;
  Members& operator=(const Members&) = delete;

  /// Whether the text is an object. If not, that is reported to `faults`, at $.
  /// \throws InvalidInput for a text that is not JSON, and no object either
  bool is_object(Faults& faults);
  /// Goes to the next member. False if there are no more. Values that were not parsed are checked
  /// only for brackets and strings. \pre is_object()
  /// \throws InvalidInput if the text is not JSON as far as this member's end
  bool next();
  const std::string& key() const noexcept { return key_; }  ///< \pre next()
  /// The text of the value. Valid as long as the whole text. \pre next()
  std::string_view value() const noexcept { return text_.substr(begin_, at_ - begin_); }
  /// The value, valid until the next call of next() or element(). No value if its text has more
  /// than `most_bytes`. \pre next() \throws InvalidInput if it is not JSON
  std::optional<Element> element(std::size_t most_bytes);
  /// Reads the whole text for its first fault. So a fault in a value is reported with its position
  /// in the whole. Returns if there is none.
  /// \throws InvalidInput
  void check_whole() const { check_syntax(text_, name_); }

 private:
  void skip_blanks();
  std::string read_key();
  [[noreturn]] void refuse(simdjson::error_code code) const;

  std::string_view text_;
  std::string name_;
  std::size_t at_ = 0;     // at the object's brace; later at what stands behind the member
  std::size_t begin_ = 0;  // of the value
  bool first_ = true;
  std::string key_;
  simdjson::dom::parser parser_;
};

/// The records of a text, in turn. A text that begins with a bracket is a list, any other is lines,
/// of which blank ones are skipped. One record is parsed at a time.
///
///     Records records(text, "train.jsonl", most_bytes);
///     while (records.next()) {
///       if (records.element()) read(*records.element(), Path(root, records.index()));
///     }
///
/// Belongs to one thread.
class Records {
 public:
  /// \param most_bytes  of a record that is parsed
  /// \pre the text outlives *this
  Records(std::string_view text, std::string name, std::size_t most_bytes);
  /// Where a part of a text of lines begins: its first record and line, from 0.
  struct Begin {
    std::size_t record = 0, line = 0;
  };
  /// The records of a part of a text of lines, without the byte order mark. \pre the text outlives
  /// *this
  Records(std::string_view lines, std::string name, std::size_t most_bytes, Begin begin);
  Records(const Records&) = delete;
  Records& operator=(const Records&) = delete;

  bool is_lines() const noexcept { return !list_; }
  /// Goes to the next record. False if there are no more.
  /// \throws InvalidInput if the text is not JSON as far as this record; for lines it names the
  /// line
  bool next();
  std::size_t index() const noexcept;  ///< from 0; blank lines do not count \pre next()
  std::size_t bytes() const noexcept;  ///< bytes of the record \pre next()
  /// Valid until the next call of next(); none if it has more than `most_bytes`. \pre next()
  const std::optional<Element>& element() const noexcept;

 private:
  bool next_line();

  std::string name_;
  std::size_t most_bytes_;
  std::optional<Entries> list_;
  // Of lines.
  std::string_view rest_;
  std::size_t line_ = 0;
  std::size_t index_ = static_cast<std::size_t>(-1);  // one before the first
  std::size_t bytes_ = 0;
  std::optional<Element> element_;
  simdjson::dom::parser parser_;
};

/// Parts of a text, of whole lines each, for parallel readers. The cuts do not depend on the number
/// of threads. A list is one part, which Records reads whole.
struct Parts {
  bool is_lines = false;
  std::vector<std::string_view> texts;  ///< of lines: without the byte order mark
  std::vector<Records::Begin> begins;   ///< beside each
};
/// \param part_bytes  approximate bytes per part
Parts split_records(std::string_view text, std::size_t part_bytes);

}  // namespace enfilade::json
