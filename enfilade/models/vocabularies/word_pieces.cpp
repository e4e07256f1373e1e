// BERT's vocabulary.
#include <fmt/format.h>
#include <utf8proc.h>
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/detail/json.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/utf8.h"
#include "enfilade/models/subwords.h"

namespace enfilade::models {
namespace {

constexpr std::uint32_t kReplacement = 0xfffd;

utf8proc_category_t category(std::uint32_t code) {
  return utf8proc_category(static_cast<utf8proc_int32_t>(code));
}
bool is_between(utf8proc_category_t kind, utf8proc_category_t first, utf8proc_category_t last) {
  return kind >= first && kind <= last;
}

bool is_blank(std::uint32_t code) {
  return code == '\t' || code == '\n' || code == '\r' ||
         is_between(category(code), UTF8PROC_CATEGORY_ZS, UTF8PROC_CATEGORY_ZP);
}

bool is_dropped(std::uint32_t code) {
  if (code == '\t' || code == '\n' || code == '\r') return false;
  return code == kReplacement ||
         is_between(category(code), UTF8PROC_CATEGORY_CC, UTF8PROC_CATEGORY_CO);
}

// The blocks of BERT's code: no kana, no Hangul, which are written with blanks or as words.
bool is_chinese(std::uint32_t code) {
  constexpr std::array<std::pair<std::uint32_t, std::uint32_t>, 8> kBlocks{{{0x3400, 0x4dbf},
                                                                            {0x4e00, 0x9fff},
                                                                            {0xf900, 0xfaff},
                                                                            {0x20000, 0x2a6df},
                                                                            {0x2a700, 0x2b73f},
                                                                            {0x2b740, 0x2b81f},
                                                                            {0x2b820, 0x2ceaf},
                                                                            {0x2f800, 0x2fa1f}}};
  return std::ranges::any_of(
      kBlocks, [code](const auto& block) { return code >= block.first && code <= block.second; });
}

// All of ASCII's signs count, also those that Unicode calls symbols: $ + < = > ^ ` | ~.
bool is_punctuation(std::uint32_t code) {
  const utf8proc_category_t kind = category(code);
  return is_between(kind, UTF8PROC_CATEGORY_PC, UTF8PROC_CATEGORY_PO) ||
         (code < 0x80 && is_between(kind, UTF8PROC_CATEGORY_SM, UTF8PROC_CATEGORY_SO));
}

// Canonical decomposition (NFD) without accents, in lower case.
void append_folded(std::uint32_t code, std::u32string& text) {
  std::array<utf8proc_int32_t, 4> parts{};  // no character has more
  int boundary = 0;
  const utf8proc_ssize_t count =
      utf8proc_decompose_char(static_cast<utf8proc_int32_t>(code), parts.data(), parts.size(),
                              UTF8PROC_DECOMPOSE, &boundary);
  for (const utf8proc_int32_t part : std::span(parts).first(static_cast<std::size_t>(count))) {
    if (utf8proc_category(part) == UTF8PROC_CATEGORY_MN) continue;
    text += static_cast<char32_t>(utf8proc_tolower(part));
  }
}

// Takes one character off the front of `text`, which is not empty; U+FFFD for a byte that begins
// none.
std::uint32_t take_character(std::string_view& text) {
  utf8proc_int32_t code = 0;
  const utf8proc_ssize_t length =
      utf8proc_iterate(reinterpret_cast<const utf8proc_uint8_t*>(text.data()),
                       static_cast<utf8proc_ssize_t>(text.size()), &code);
  text.remove_prefix(static_cast<std::size_t>(std::max<utf8proc_ssize_t>(length, 1)));
  return length > 0 ? static_cast<std::uint32_t>(code) : kReplacement;
}

// The words of a text in BERT's sense: without control characters, split at blanks. Each CJK
// character and each punctuation mark is a word of its own. Folded if `letters` requires it.
std::vector<std::u32string> words_of(std::string_view text, Letters letters) {
  std::u32string clean;
  while (!text.empty()) {
    const std::uint32_t code = take_character(text);
    if (is_dropped(code)) continue;
    if (is_blank(code)) {
      clean += U' ';
    } else if (is_chinese(code)) {
      clean += U' ';
      letters == Letters::kFolded ? append_folded(code, clean)
                                  : clean.push_back(static_cast<char32_t>(code));
      clean += U' ';
    } else if (letters == Letters::kFolded) {
      append_folded(code, clean);
    } else {
      clean += static_cast<char32_t>(code);
    }
  }
  std::vector<std::u32string> words;
  bool open = false;  // whether the last word goes on
  for (const char32_t code : clean) {
    const bool mark = is_punctuation(code);
    if (code == U' ') {
      open = false;
      continue;
    }
    if (!open || mark) words.emplace_back();
    words.back() += code;
    open = !mark;
  }
  return words;
}

constexpr std::size_t kLongestWord = 100;  // characters; longer ones are unknown
constexpr std::string_view kInside = "##";

class WordPieces : public Subwords::Pieces {
 public:
  explicit WordPieces(Letters letters) : letters_(letters) {}

  void cut(std::string_view text, std::vector<std::int32_t>& out) const override {
    for (const std::u32string& word : words_of(text, letters_)) cut_word(word, out);
  }

  std::size_t longest = 0;  // bytes of the longest piece

 private:
  void cut_word(const std::u32string& word, std::vector<std::int32_t>& out) const {
    const std::size_t before = out.size();
    if (word.size() > kLongestWord || !pieces_of(word, out)) {
      out.resize(before);
      out.push_back(static_cast<std::int32_t>(unknown));
    }
  }

  // The longest piece from each position on. False if a position has none.
  bool pieces_of(const std::u32string& word, std::vector<std::int32_t>& out) const {
    for (std::size_t from = 0; from < word.size();) {
      std::string piece(from == 0 ? "" : kInside);
      std::size_t to = 0;
      std::uint32_t best = 0;
      for (std::size_t k = from; k < word.size() && piece.size() <= longest; ++k) {
        append_utf8(word[k], piece);
        if (const auto found = ids.find(piece); found != ids.end()) {
          to = k + 1;
          best = found->second;
        }
      }
      if (to == 0) return false;
      out.push_back(static_cast<std::int32_t>(best));
      from = to;
    }
    return true;
  }

  Letters letters_;
};

// Lists what is wrong with a vocabulary.
class Reader {
 public:
  explicit Reader(const std::string& origin) : origin_(origin) {}

  void read(std::string_view text, WordPieces& pieces) {
    text = without_byte_order_mark(text);
    for (;;) {  // blank lines at the end
      const std::size_t blank = text.ends_with("\n\n") ? 1 : text.ends_with("\n\r\n") ? 2 : 0;
      if (blank == 0) break;
      text.remove_suffix(blank);
    }
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      std::string_view line = text.substr(0, end);
      text.remove_prefix(std::min(end + 1, text.size()));
      if (line.ends_with('\r')) line.remove_suffix(1);
      if (line.empty()) fault(pieces, "empty-line", "no piece");
      if (!simdjson::validate_utf8(line))
        fault(pieces, "not-utf8", fmt::format("{}, not UTF-8", quote(line)));
      pieces.longest = std::max(pieces.longest, line.size());
      pieces.names.emplace_back(line);
    }
    for (std::size_t id = 0; id < pieces.names.size(); ++id) {
      const auto [first, fresh] =
          pieces.ids.emplace(pieces.names[id], static_cast<std::uint32_t>(id));
      if (fresh || pieces.names[id].empty()) continue;
      add(fmt::format("line {}", id + 1), "repeated-piece",
          fmt::format("{} stands on line {} already", quote(pieces.names[id]), first->second + 1));
    }
  }

  std::uint32_t special(const WordPieces& pieces, std::string_view name) {
    const auto found = pieces.ids.find(name);
    if (found != pieces.ids.end()) return found->second;
    add("", "missing-piece", fmt::format("{} is not in it; is it a BERT vocabulary?", name));
    return 0;
  }

  void finish() {
    if (!faults_.empty()) throw InvalidInput(std::move(faults_));
  }

 private:
  void fault(const WordPieces& pieces, const char* code, std::string message) {
    add(fmt::format("line {}", pieces.names.size() + 1), code, std::move(message));
  }
  void add(std::string where, const char* code, std::string message) {
    if (faults_.size() == kMostFaultsKept) return;
    faults_.push_back({Severity::kError, origin_, std::move(where), code, std::move(message)});
  }

  std::string origin_;
  std::vector<Diagnostic> faults_;
};

}  // namespace

Subwords Subwords::parse_word_pieces(std::string_view text, const std::string& origin,
                                     Letters letters) {
  const auto pieces = std::make_shared<WordPieces>(letters);
  Reader reader(origin);
  reader.read(text, *pieces);
  pieces->pad = reader.special(*pieces, "[PAD]");
  pieces->unknown = reader.special(*pieces, "[UNK]");
  pieces->begin = reader.special(*pieces, "[CLS]");
  pieces->end = reader.special(*pieces, "[SEP]");
  if (const auto mask = pieces->ids.find("[MASK]"); mask != pieces->ids.end()) {
    pieces->mask = mask->second;
  }
  reader.finish();
  return Subwords(pieces);
}

}  // namespace enfilade::models
