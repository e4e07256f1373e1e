#include "enfilade/models/vocabularies/model_file.h"

#include <fmt/format.h>
#include <bit>
#include <cmath>
#include <cstring>

#include "enfilade/core/errors.h"

namespace enfilade::models::vocabularies {
namespace {

constexpr std::uint64_t kUnigram = 1;

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
    switch (wire_) {
      case 0:
        number_ = read_number();
        break;
      case 1:
        text_ = take(8);
        break;
      case 2:
        text_ = take(read_number());
        break;
      case 5:
        text_ = take(4);
        break;
      default:
        fail(fmt::format("wire type {}", wire_));
    }
    return true;
  }

  std::uint64_t field() const { return field_; }
  std::uint64_t number() const { return expect(0), number_; }
  std::string_view text() const { return expect(2), text_; }
  float single() const {
    expect(5);
    std::uint32_t bits = 0;
    for (std::size_t k = 4; k-- > 0;) bits = bits << 8U | static_cast<unsigned char>(text_[k]);
    return std::bit_cast<float>(bits);
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

}  // namespace

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

}  // namespace enfilade::models::vocabularies
