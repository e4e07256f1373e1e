#include "enfilade/models/subwords.h"

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/written_lists.h"

namespace enfilade::models {

Subwords Subwords::load_word_pieces(const std::filesystem::path& file, Letters letters) {
  return parse_word_pieces(read_plain_text(file), file.string(), letters);
}

Subwords Subwords::load_sentence_pieces(const std::filesystem::path& file) {
  return parse_sentence_pieces(read_file(file), file.string());
}

Subwords Subwords::load(const std::filesystem::path& file, Letters letters) {
  return file.extension() == ".model" ? load_sentence_pieces(file)
                                      : load_word_pieces(file, letters);
}

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
