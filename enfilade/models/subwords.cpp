#include "enfilade/models/subwords.h"

#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/models/vocabularies/pieces.h"

namespace enfilade::models {

Subwords::Subwords(std::shared_ptr<const Pieces> pieces) : pieces_(std::move(pieces)) {}

Subwords Subwords::load_word_pieces(const std::filesystem::path& file, Letters letters) {
  return parse_word_pieces(read_file(file), file.string(), letters);
}
Subwords Subwords::parse_word_pieces(std::string_view text, const std::string& origin,
                                     Letters letters) {
  return Subwords(vocabularies::word_pieces(text, origin, letters));
}

Subwords Subwords::load_sentence_pieces(const std::filesystem::path& file) {
  return parse_sentence_pieces(read_file(file), file.string());
}
Subwords Subwords::parse_sentence_pieces(std::string_view bytes, const std::string& origin) {
  return Subwords(vocabularies::sentence_pieces(bytes, origin));
}

Subwords Subwords::load(const std::filesystem::path& file, Letters letters) {
  return file.extension() == ".model" ? load_sentence_pieces(file)
                                      : load_word_pieces(file, letters);
}

std::size_t Subwords::size() const noexcept { return pieces_->names.size(); }
std::uint32_t Subwords::begin() const noexcept { return pieces_->begin; }
std::uint32_t Subwords::end() const noexcept { return pieces_->end; }
std::uint32_t Subwords::pad() const noexcept { return pieces_->pad; }
std::uint32_t Subwords::unknown() const noexcept { return pieces_->unknown; }
std::optional<std::uint32_t> Subwords::mask() const noexcept { return pieces_->mask; }

std::string_view Subwords::piece(std::uint32_t id) const {
  EN_CHECK_LT(id, pieces_->names.size());
  return pieces_->names[id];
}

std::optional<std::uint32_t> Subwords::find(std::string_view piece) const {
  const auto found = pieces_->ids.find(piece);
  return found == pieces_->ids.end() ? std::nullopt : std::optional(found->second);
}

std::vector<std::int32_t> Subwords::encode(std::string_view text) const {
  std::vector<std::int32_t> ids{static_cast<std::int32_t>(begin())};
  pieces_->cut(text, ids);
  ids.push_back(static_cast<std::int32_t>(end()));
  return ids;
}

void encode_instructions(tasks::Annotations& annotations, const Subwords& words) {
  if (annotations.task == tasks::Task::kCvdn) {
    throw ArgumentError(annotations.file +
                        ": CVDN's token ids are those of a dialogue, which is not one text");
  }
  for (tasks::PathAnnotation& path : annotations.paths) {
    path.details.resize(path.instructions.size());
    for (std::size_t k = 0; k < path.instructions.size(); ++k) {
      path.details[k].tokens = words.encode(path.instructions[k]);
    }
  }
}

}  // namespace enfilade::models
