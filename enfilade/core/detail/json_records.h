/// \file  Reading of the two forms in which data sets keep many records: a JSON list, and JSON
/// Lines (https://jsonlines.org: a value a line). Internal, as it includes simdjson.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/detail/json.h"
#include "enfilade/core/detail/json_entries.h"

namespace enfilade::json {

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
