/// \file  The vocabularies that released agents were trained with.
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "enfilade/models/train_config.h"

namespace enfilade::neural::detail {

/// A released vocabulary, by the rows of a network's table of words.
struct KnownVocabulary {
  std::string where;  ///< "bert-base-uncased's: https://...", or a general description
  models::Letters letters = models::Letters::kFolded;
};
KnownVocabulary known_vocabulary(std::size_t rows);

/// SentencePiece's by the name `.model`, word pieces by the line "[CLS]", else words.
models::TextKind text_kind_of(const std::filesystem::path& file, std::string_view content);

/// The words or pieces in a vocabulary of the training's kind of text. \throws InvalidInput
std::size_t entries_in(const std::filesystem::path& file, const std::string& content,
                       const models::TrainConfig& training);

/// Rows of `<BOS>` and `<MASK>` beside those of words; none beside pieces.
std::size_t rows_of_marks(const models::TrainConfig& training);

}  // namespace enfilade::neural::detail
