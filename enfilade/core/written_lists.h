/// \file  Lists that people write in editors and spreadsheets: ids, names, words, tables of text.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade {

/// UTF-8 without a byte-order mark, as editors of any system save a text. UTF-16 is recognised by
/// its mark (Excel's "Unicode text", PowerShell's `>`); halves of characters become U+FFFD. A text
/// without a mark is returned unchanged.
std::string plain_text(std::string content);

/// More than any list that people write.
inline constexpr std::size_t kMostListBytes = std::size_t{1} << 26U;
/// The plain_text() of a file, which may be packed with gzip.
/// \throws FileError naming the path, also for more than `most` bytes
std::string read_plain_text(const std::filesystem::path& file, std::size_t most = kMostListBytes);

/// Without the blanks, tabs, line breaks and no-break spaces at both ends.
std::string_view trimmed(std::string_view text) noexcept;

/// One line of a list.
struct ListLine {
  std::size_t number = 0;  ///< in the file, from 1
  std::string_view text;   ///< trimmed
};

/// What lines of a list that begin with # are.
enum class HashLines : std::uint8_t { kComments, kEntries };

/// The lines of a list without blank ones and comments. A line ends with LF, CR LF or CR.
/// \param text  plain_text(); the lines are views into it
std::vector<ListLine> list_lines(std::string_view text, HashLines hash = HashLines::kComments);

/// All lines of a text, as they stand but without their ends; none after a last line break. For
/// vocabularies and tables, in which blanks and blank lines count.
std::vector<std::string_view> all_lines(std::string_view text);

}  // namespace enfilade
