// BERT's vocabulary.
#include <fmt/format.h>
#include <algorithm>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/utf8.h"
#include "enfilade/models/vocabularies/characters.h"
#include "enfilade/models/vocabularies/pieces.h"

namespace enfilade::models::vocabularies {
namespace {

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

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

// Lists what is wrong with a vocabulary.
class Reader {
 public:
  explicit Reader(const std::string& origin) : origin_(origin) {}

  void read(std::string_view text, WordPieces& pieces) {
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      std::string_view line = text.substr(0, end);
      text.remove_prefix(std::min(end + 1, text.size()));
      if (line.ends_with('\r')) line.remove_suffix(1);
      if (line.empty()) fault(pieces, "empty-line", "no piece");
      if (!is_utf8(line)) fault(pieces, "not-utf8", fmt::format("{:?}, not UTF-8", line));
      pieces.longest = std::max(pieces.longest, line.size());
      pieces.names.emplace_back(line);
    }
    for (std::size_t id = 0; id < pieces.names.size(); ++id) {
      const auto [first, fresh] =
          pieces.ids.emplace(pieces.names[id], static_cast<std::uint32_t>(id));
      if (fresh || pieces.names[id].empty()) continue;
      add(fmt::format("line {}", id + 1), "repeated-piece",
          fmt::format("{:?} stands on line {} already", pieces.names[id], first->second + 1));
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

std::shared_ptr<const Subwords::Pieces> word_pieces(std::string_view text,
                                                    const std::string& origin, Letters letters) {
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
  return pieces;
}

}  // namespace enfilade::models::vocabularies
