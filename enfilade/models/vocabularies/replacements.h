/// \file  The table by which SentencePiece replaces characters before it cuts a text.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace enfilade::models::vocabularies {

/// A `precompiled_charsmap`. It has the size of a double-array trie in bytes, the trie (Darts,
/// units of 32 bits), and the texts of its values. A zero byte follows each text. Little-endian.
class Replacements {
 public:
  /// No replacement.
  Replacements() = default;
  /// \throws InvalidInput for a size that does not fit
  Replacements(std::string_view table, const std::string& origin);

  /// The replacement of the longest beginning of `text` that the table has, and that beginning's
  /// bytes; 0 bytes if it has none.
  /// \throws InvalidInput for a table that points outside
  std::pair<std::string_view, std::size_t> longest(std::string_view text) const;

 private:
  std::uint32_t unit(std::size_t at) const;
  [[noreturn]] void fail(const std::string& what) const;

  std::vector<std::uint32_t> units_;
  std::string texts_, origin_;
};

}  // namespace enfilade::models::vocabularies
