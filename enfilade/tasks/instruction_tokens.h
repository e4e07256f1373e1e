/// \file  The tokens of VLN-CE's instructions, as its files have them.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "enfilade/tasks/continuous_episodes.h"

namespace enfilade::tasks {

/// The words of a text by the rule of Habitat's loader: lower case; a blank before each "'s";
/// commas and question marks removed. The text is split on runs of characters that are not letters,
/// digits, _ or -; those runs are kept, without the blanks around them. Bytes above 127 count as
/// letters and are not changed.
std::vector<std::string> tokenize_continuous(std::string_view text);

/// Ids of words by a file's vocabulary. Immutable: any thread.
class InstructionEncoder {
 public:
  /// Tokens of an instruction in R2R-CE's files.
  static constexpr std::size_t kLength = 200;

  /// \throws ArgumentError if the vocabulary has no words, or one twice, or if its unknown or
  /// padding token (default: 1 and 0) is beyond the range of a token
  explicit InstructionEncoder(const InstructionVocabulary& vocabulary);

  /// The ids of a text's words, in their order, padded and cut to `length`.
  std::vector<std::int32_t> encode(std::string_view text, std::size_t length = kLength) const;

 private:
  std::unordered_map<std::string, std::int32_t> ids_;
  std::int32_t unknown_ = 1, padding_ = 0;
};

}  // namespace enfilade::tasks
