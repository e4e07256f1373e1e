/// \file  SentencePiece's model files.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade::models::vocabularies {

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

/// Reads the protocol buffer ModelProto (sentencepiece_model.proto); unknown fields are read over.
/// \throws InvalidInput for other bytes, a model that is not unigram, and for what this library
/// does not follow: pieces for bytes, blanks behind words
ModelFile parse_model_file(std::string_view bytes, const std::string& origin);

}  // namespace enfilade::models::vocabularies
