// XLM-R's vocabulary: SentencePiece's unigram model, as its own code cuts text.
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"
#include "enfilade/core/utf8.h"
#include "enfilade/models/subwords.h"

namespace enfilade::models {
namespace {

/// A piece as the file has it.
struct ModelPiece {
  /// The file's numbers.
  enum class Kind : std::uint8_t {
    kNormal = 1,
    kUnknown = 2,
    kControl = 3,
    kUserDefined = 4,
    kUnused = 5,
    kByte = 6,
  };
  std::string text;
  float score = 0;  ///< log of its probability
  Kind kind = Kind::kNormal;
};

/// The used parts of a model.
struct ModelFile {
  std::vector<ModelPiece> pieces;
  std::string replacements;      ///< `precompiled_charsmap`: a trie and texts; empty: none
  bool begin_with_blank = true;  ///< `add_dummy_prefix`
  bool join_blanks = true;       ///< `remove_extra_whitespaces`
  bool mark_blanks = true;       ///< `escape_whitespaces`: U+2581 for a blank
};

constexpr std::uint64_t kUnigram = 1;

// Of four bytes.
std::uint32_t little_endian(std::string_view bytes) {
  std::uint32_t value = 0;
  for (std::size_t k = 4; k-- > 0;) value = value << 8U | static_cast<unsigned char>(bytes[k]);
  return value;
}

// A message of a protocol buffer, field by field.
class Message {
 public:
  Message(std::string_view bytes, const std::string& origin, std::string where)
      : left_(bytes), origin_(origin), where_(std::move(where)) {}

  /// Goes on to the next field. False at the end.
  bool next() {
    if (left_.empty()) return false;
    const std::uint64_t key = read_number();
    field_ = key >> 3U;
    wire_ = static_cast<unsigned>(key & 7U);
    if (wire_ == 0) {
      number_ = read_number();
    } else if (wire_ == 2) {
      text_ = take(read_number());
    } else if (wire_ == 1 || wire_ == 5) {
      text_ = take(wire_ == 1 ? 8 : 4);
    } else {
      fail(fmt::format("wire type {}", wire_));
    }
    return true;
  }

  std::uint64_t field() const { return field_; }
  std::uint64_t number() const { return expect(0), number_; }
  std::string_view text() const { return expect(2), text_; }
  float single() const {
    expect(5);
    return std::bit_cast<float>(little_endian(text_));
  }
  Message message(std::string where) const { return {text(), origin_, std::move(where)}; }
  [[noreturn]] void fail(const std::string& what) const {
    refuse(origin_, where_, "not-sentencepiece",
           what + ": not a SentencePiece model that can be read");
  }

 private:
  void expect(unsigned wire) const {
    if (wire_ != wire) fail(fmt::format("field {} has wire type {}, not {}", field_, wire_, wire));
  }

  std::uint64_t read_number() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
      if (left_.empty()) fail("ends inside a number");
      const auto byte = static_cast<unsigned char>(left_.front());
      left_.remove_prefix(1);
      value |= std::uint64_t{byte & 0x7fU} << shift;
      if (byte < 0x80) return value;
    }
    fail("a number of more than ten bytes");
  }

  std::string_view take(std::uint64_t size) {
    if (size > left_.size()) fail(fmt::format("{} bytes wanted, {} left", size, left_.size()));
    const std::string_view taken = left_.substr(0, size);
    left_.remove_prefix(size);
    return taken;
  }

  std::string_view left_, text_;
  std::string origin_, where_;
  std::uint64_t field_ = 0, number_ = 0;
  unsigned wire_ = 0;
};

ModelPiece read_piece(Message message) {
  ModelPiece piece;
  while (message.next()) {
    if (message.field() == 1) piece.text = message.text();
    if (message.field() == 2) piece.score = message.single();
    if (message.field() != 3) continue;
    const std::uint64_t kind = message.number();
    if (kind < 1 || kind > 6) message.fail(fmt::format("a piece of type {}, not 1 to 6", kind));
    piece.kind = static_cast<ModelPiece::Kind>(kind);
  }
  if (!std::isfinite(piece.score)) message.fail(fmt::format("score {}", piece.score));
  if (piece.kind == ModelPiece::Kind::kByte) message.fail("a piece for a byte");
  if (piece.text.empty()) message.fail("a piece without text");
  return piece;
}

void check_training(Message message) {
  while (message.next()) {
    if (message.field() == 3 && message.number() != kUnigram) {
      message.fail(fmt::format("model_type {}, not 1 (unigram)", message.number()));
    }
    if (message.field() == 24 && message.number() != 0) {
      message.fail("treat_whitespace_as_suffix");
    }
    if (message.field() == 35 && message.number() != 0) message.fail("byte_fallback");
  }
}

void read_rules(Message message, ModelFile& model) {
  while (message.next()) {
    if (message.field() == 2) model.replacements = message.text();
    if (message.field() == 3) model.begin_with_blank = message.number() != 0;
    if (message.field() == 4) model.join_blanks = message.number() != 0;
    if (message.field() == 5) model.mark_blanks = message.number() != 0;
  }
}

// Reads the protocol buffer ModelProto (sentencepiece_model.proto); unknown fields are read over.
// \throws InvalidInput for other bytes, a model that is not unigram, and for what this library
// does not follow: pieces for bytes, blanks behind words
ModelFile parse_model_file(std::string_view bytes, const std::string& origin) {
  ModelFile model;
  Message message(bytes, origin, "$");
  while (message.next()) {
    if (message.field() == 1) {
      model.pieces.push_back(
          read_piece(message.message(fmt::format("$.pieces[{}]", model.pieces.size()))));
    }
    if (message.field() == 2) check_training(message.message("$.trainer_spec"));
    if (message.field() == 3) read_rules(message.message("$.normalizer_spec"), model);
  }
  return model;
}

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

// A unit's parts: where its children begin, relative to it, and which byte leads to it.
std::uint32_t offset_of(std::uint32_t unit) { return (unit >> 10U) << ((unit & 0x200U) >> 6U); }
std::uint32_t label_of(std::uint32_t unit) { return unit & 0x800000ffU; }
bool has_value(std::uint32_t unit) { return (unit & 0x100U) != 0; }
std::uint32_t value_of(std::uint32_t unit) { return unit & 0x7fffffffU; }

Replacements::Replacements(std::string_view table, const std::string& origin) : origin_(origin) {
  if (table.empty()) return;
  constexpr std::size_t kHead = 4, kUnit = 4;
  const std::size_t size = table.size() < kHead ? 0 : little_endian(table);
  if (size == 0 || size % kUnit != 0 || size > table.size() - kHead) {
    fail(fmt::format("a trie of {} bytes in {}", size, table.size()));
  }
  for (std::size_t at = kHead; at < kHead + size; at += kUnit) {
    units_.push_back(little_endian(table.substr(at)));
  }
  texts_ = table.substr(kHead + size);
  if (!texts_.ends_with('\0')) fail("no zero byte at the end of the texts");
}

std::pair<std::string_view, std::size_t> Replacements::longest(std::string_view text) const {
  std::pair<std::string_view, std::size_t> best{{}, 0};
  if (units_.empty()) return best;
  std::size_t at = offset_of(unit(0));
  for (std::size_t k = 0; k < text.size(); ++k) {
    const auto byte = static_cast<unsigned char>(text[k]);
    if ((at ^ byte) >= units_.size()) break;  // no child
    at ^= byte;
    const std::uint32_t node = units_[at];
    if (label_of(node) != byte) break;
    at ^= offset_of(node);
    if (!has_value(node)) continue;
    const std::uint32_t value = value_of(unit(at));
    if (value >= texts_.size()) fail(fmt::format("text {} of {} bytes", value, texts_.size()));
    best = {std::string_view(texts_.c_str() + value), k + 1};
  }
  return best;
}

std::uint32_t Replacements::unit(std::size_t at) const {
  if (at >= units_.size()) fail(fmt::format("unit {} of {}", at, units_.size()));
  return units_[at];
}

void Replacements::fail(const std::string& what) const {
  refuse(origin_, "$.normalizer_spec.precompiled_charsmap", "bad-table", what);
}

using Kind = ModelPiece::Kind;

constexpr std::string_view kBlank = "\xE2\x96\x81";            // U+2581
constexpr std::string_view kReplacementText = "\xEF\xBF\xBD";  // U+FFFD
constexpr float kUnknownPenalty = 10;                          // below the least probable piece
constexpr std::uint32_t kShift = 1;                            // fairseq's ids are one more

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
    if (length == 0) return {kReplacementText, 1};
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
           fmt::format("{}, not {}, as XLM-R's begin",
                       quote(k < model.pieces.size() ? model.pieces[k].text : ""), quote(name)));
  }
}

}  // namespace

Subwords Subwords::parse_sentence_pieces(std::string_view bytes, const std::string& origin) {
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
           fmt::format("{} stands in it twice", quote(pieces->names[id])));
  }
  pieces->begin = 0;
  pieces->pad = 1;
  pieces->end = 2;
  pieces->unknown = 3;
  pieces->mask = static_cast<std::uint32_t>(pieces->names.size() - 1);
  return Subwords(pieces);
}

}  // namespace enfilade::models
