// XLM-R's vocabulary: SentencePiece's unigram model, as its own code cuts text.
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/utf8.h"
#include "enfilade/models/vocabularies/model_file.h"
#include "enfilade/models/vocabularies/pieces.h"
#include "enfilade/models/vocabularies/replacements.h"

namespace enfilade::models::vocabularies {
namespace {

using Kind = ModelPiece::Kind;

constexpr std::string_view kBlank = "\xE2\x96\x81";        // U+2581
constexpr std::string_view kReplacement = "\xEF\xBF\xBD";  // U+FFFD
constexpr float kUnknownPenalty = 10;                      // below the least probable piece
constexpr std::uint32_t kShift = 1;                        // fairseq's ids are one more

std::size_t character_length(std::string_view text) {
  return std::max<std::size_t>(utf8_length(text), 1);
}

class SentencePieces : public Subwords::Pieces {
 public:
  SentencePieces(ModelFile model, const std::string& origin)
      : model_(std::move(model)), replacements_(model_.replacements, origin) {
    float least = std::numeric_limits<float>::max();
    for (std::uint32_t k = 0; k < model_.pieces.size(); ++k) {
      const ModelPiece& piece = model_.pieces[k];
      if (piece.kind == Kind::kNormal) {
        least = std::min(least, piece.score);
        most_ = std::max(most_, piece.score);
      }
      if (piece.kind == Kind::kUserDefined) own_.emplace_back(piece.text);
      if (piece.kind == Kind::kNormal || piece.kind == Kind::kUserDefined) {
        known_.emplace(piece.text, k);
        longest_ = std::max(longest_, piece.text.size());
      }
    }
    // The longest comes first.
    std::ranges::sort(own_, std::ranges::greater{}, &std::string::size);
    unknown_score_ = least - kUnknownPenalty;
  }

  void cut(std::string_view text, std::vector<std::int32_t>& out) const override {
    bool was_unknown = false;
    for (const std::uint32_t piece : best_pieces(normalised(text))) {
      const bool is_unknown = piece == 0;
      // A run of what no piece makes is one.
      if (!is_unknown || !was_unknown) {
        out.push_back(static_cast<std::int32_t>(is_unknown ? unknown : piece + kShift));
      }
      was_unknown = is_unknown;
    }
  }

 private:
  // What stands for the beginning of a text, and how many bytes it stands for.
  std::pair<std::string_view, std::size_t> replaced(std::string_view text) const {
    for (const std::string& piece : own_) {
      if (text.starts_with(piece)) return {piece, piece.size()};
    }
    if (const auto found = replacements_.longest(text); found.second > 0) return found;
    const std::size_t length = utf8_length(text);
    if (length == 0) return {kReplacement, 1};
    return {text.substr(0, length), length};
  }

  // Characters replaced, blanks joined and marked, a blank in front.
  std::string normalised(std::string_view text) const {
    const bool join = model_.join_blanks;
    std::string clean;
    bool after_blank = join;
    while (!text.empty()) {
      auto [part, length] = replaced(text);
      text.remove_prefix(length);
      while (after_blank && part.starts_with(' ')) part.remove_prefix(1);
      if (part.empty()) continue;
      if (clean.empty() && model_.begin_with_blank) append_blank(clean);
      for (const char byte : part) {
        byte == ' ' ? append_blank(clean) : clean.push_back(byte);
      }
      after_blank = join && part.ends_with(' ');
    }
    const std::string_view blank = model_.mark_blanks ? kBlank : std::string_view(" ");
    while (join && clean.ends_with(blank)) clean.resize(clean.size() - blank.size());
    return clean;
  }

  void append_blank(std::string& text) const {
    text += model_.mark_blanks ? kBlank : std::string_view(" ");
  }

  // How good a piece of a text's `length` bytes is.
  float score_of(const ModelPiece& piece, std::size_t length) const {
    if (piece.kind != Kind::kUserDefined) return piece.score;
    return static_cast<float>(static_cast<double>(static_cast<float>(length) * most_) - 0.1);
  }

  // The best way to each place of the text: the last piece, and where that begins.
  struct Best {
    std::size_t begin = std::string::npos;
    std::uint32_t piece = 0;
    float score = 0;
    void offer(std::size_t from, std::uint32_t what, float total) {
      if (begin != std::string::npos && total <= score) return;
      *this = {from, what, total};
    }
  };

  std::vector<std::uint32_t> best_pieces(std::string_view text) const {
    std::vector<Best> best(text.size() + 1);
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t one = std::min(character_length(text.substr(at)), text.size() - at);
      offer_pieces(text, at, one, best);
      at += one;
    }
    std::vector<std::uint32_t> pieces;
    for (std::size_t at = text.size(); at > 0; at = best[at].begin) {
      pieces.push_back(best[at].piece);
    }
    std::ranges::reverse(pieces);
    return pieces;
  }

  // The pieces that begin at a position; if the character there is not a piece, it is unknown.
  void offer_pieces(std::string_view text, std::size_t at, std::size_t one,
                    std::vector<Best>& best) const {
    const float before = best[at].score;
    bool single = false;
    const std::size_t most = std::min(longest_, text.size() - at);
    for (std::size_t length = one; length <= most;) {
      const auto found = known_.find(text.substr(at, length));
      if (found != known_.end()) {
        best[at + length].offer(at, found->second,
                                score_of(model_.pieces[found->second], length) + before);
        single = single || length == one;
      }
      if (at + length >= text.size()) break;
      length += character_length(text.substr(at + length));
    }
    if (!single) best[at + one].offer(at, 0, unknown_score_ + before);
  }

  ModelFile model_;
  Replacements replacements_;
  std::vector<std::string> own_;
  std::unordered_map<std::string_view, std::uint32_t> known_;  // what text is cut into
  std::size_t longest_ = 0;
  float most_ = std::numeric_limits<float>::lowest(), unknown_score_ = 0;
};

void check_beginning(const ModelFile& model, const std::string& origin) {
  constexpr std::array<std::pair<std::string_view, Kind>, 3> kFirst{
      {{"<unk>", Kind::kUnknown}, {"<s>", Kind::kControl}, {"</s>", Kind::kControl}}};
  for (std::size_t k = 0; k < kFirst.size(); ++k) {
    const auto& [name, kind] = kFirst[k];
    if (k < model.pieces.size() && model.pieces[k].text == name && model.pieces[k].kind == kind) {
      continue;
    }
    refuse(origin, fmt::format("$.pieces[{}]", k), "other-pieces",
           fmt::format("{:?}, not {:?}, as XLM-R's begin",
                       k < model.pieces.size() ? model.pieces[k].text : "", name));
  }
}

}  // namespace

std::shared_ptr<const Subwords::Pieces> sentence_pieces(std::string_view bytes,
                                                        const std::string& origin) {
  ModelFile model = parse_model_file(bytes, origin);
  check_beginning(model, origin);
  std::vector<std::string> names{"<s>", "<pad>", "</s>", "<unk>"};
  for (std::size_t k = 3; k < model.pieces.size(); ++k) names.push_back(model.pieces[k].text);
  names.emplace_back("<mask>");
  const auto pieces = std::make_shared<SentencePieces>(std::move(model), origin);
  pieces->names = std::move(names);
  for (std::size_t id = 0; id < pieces->names.size(); ++id) {
    const auto number = static_cast<std::uint32_t>(id);
    if (pieces->ids.emplace(pieces->names[id], number).second) continue;
    refuse(origin, fmt::format("$.pieces[{}]", id - kShift), "repeated-piece",
           fmt::format("{:?} stands in it twice", pieces->names[id]));
  }
  pieces->begin = 0;
  pieces->pad = 1;
  pieces->end = 2;
  pieces->unknown = 3;
  pieces->mask = static_cast<std::uint32_t>(pieces->names.size() - 1);
  return pieces;
}

}  // namespace enfilade::models::vocabularies
