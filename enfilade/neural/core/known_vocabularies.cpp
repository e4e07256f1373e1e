#include "enfilade/neural/core/known_vocabularies.h"

#include <fmt/format.h>
#include <array>

#include "enfilade/models/subwords.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::neural::core {
namespace {

using models::Letters;
using models::TextKind;

struct Row {
  std::size_t rows;
  std::string_view where;
  Letters letters;
};
// Sizes of the published vocabularies; EnvDrop appends <BOS> to the 991 words of R2R's training.
constexpr std::array<Row, 4> kKnown{{
    {30'522, "that of bert-base-uncased: vocab.txt in https://huggingface.co/bert-base-uncased",
     Letters::kFolded},
    {28'996, "that of bert-base-cased: vocab.txt in https://huggingface.co/bert-base-cased",
     Letters::kAsWritten},
    {250'002,
     "that of xlm-roberta-base: sentencepiece.bpe.model in "
     "https://huggingface.co/xlm-roberta-base",
     Letters::kAsWritten},
    {992, "EnvDrop's 991 words, one a line: tasks/R2R/data/train_vocab.txt of its code",
     Letters::kFolded},
}};

}  // namespace

KnownVocabulary known_vocabulary(std::size_t rows) {
  for (const Row& row : kKnown) {
    if (row.rows == rows) return {std::string(row.where), row.letters};
  }
  return {
      "the one that the weights were trained with: vocab.txt of BERT's form, "
      "sentencepiece.bpe.model of XLM-R's, or a word a line",
      Letters::kFolded};
}

TextKind text_kind_of(const std::filesystem::path& file, std::string_view content) {
  if (file.extension() == ".model") return TextKind::kSentencePieces;
  for (const std::string_view mark : {"\n[CLS]\n", "\n[CLS]\r\n"}) {
    if (content.find(mark) != std::string_view::npos) return TextKind::kWordPieces;
  }
  return content.starts_with("[CLS]\n") ? TextKind::kWordPieces : TextKind::kWords;
}

std::size_t entries_in(const std::filesystem::path& file, const std::string& content,
                       const models::TrainConfig& training) {
  switch (training.text) {
    case TextKind::kWordPieces:
      return models::Subwords::parse_word_pieces(content, file.string(), training.letters).size();
    case TextKind::kSentencePieces:
      return models::Subwords::parse_sentence_pieces(content, file.string()).size();
    case TextKind::kWords:
      break;
  }
  return tasks::Vocabulary::load(file).size();
}

std::size_t rows_of_marks(const models::TrainConfig& training) {
  models::TrainConfig none = training;
  none.network.vocabulary = 0;
  return training.agent == models::AgentKind::kDuet
             ? static_cast<std::size_t>(duet_sizes(none).vocabulary)
             : panoramic_sizes(none).vocabulary;
}

}  // namespace enfilade::neural::core
