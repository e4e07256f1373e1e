// Vocabularies of word pieces. The first byte says which: 'w' and 'c' a vocab.txt, folded and as
// written, with a text behind its first zero byte; any other one a SentencePiece model, with a text
// of so many bytes at its end. What is accepted has ids that name pieces, and cuts the text.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/models/subwords.h"

namespace {

using namespace enfilade;
using models::Letters;
using models::Subwords;

void check(const Subwords& words, std::string_view text) {
  for (const std::string_view one : {text, std::string_view("Walk caf\xC3\xA9 \xE5\xB7\xA6.")}) {
    for (const std::int32_t id : words.encode(one)) {
      const auto number = static_cast<std::uint32_t>(id);
      EN_CHECK(words.find(words.piece(number)) == number);
    }
  }
  EN_CHECK_LT(words.unknown(), words.size());
  EN_CHECK_LT(words.mask().value_or(0), words.size());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view bytes(reinterpret_cast<const char*>(data + 1), size - 1);
  try {
    if (data[0] == 'w' || data[0] == 'c') {
      const std::size_t end = std::min(bytes.find('\0'), bytes.size());
      const auto letters = data[0] == 'w' ? Letters::kFolded : Letters::kAsWritten;
      check(Subwords::parse_word_pieces(bytes.substr(0, end), "<fuzz>", letters),
            bytes.substr(std::min(end + 1, bytes.size())));
    } else {
      const std::size_t end = bytes.size() - std::min<std::size_t>(data[0], bytes.size());
      check(Subwords::parse_sentence_pieces(bytes.substr(0, end), "<fuzz>"), bytes.substr(end));
    }
  } catch (const Error&) {
  }
  return 0;
}
