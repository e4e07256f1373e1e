/// \file  Common parts of vocabularies of word pieces, from any file.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "enfilade/models/subwords.h"

namespace enfilade::models {

class Subwords::Pieces {
 public:
  virtual ~Pieces() = default;
  Pieces() = default;
  Pieces(const Pieces&) = delete;
  Pieces& operator=(const Pieces&) = delete;

  /// Appends the ids of a text, without special ones around them.
  virtual void cut(std::string_view text, std::vector<std::int32_t>& ids) const = 0;

  std::vector<std::string> names;                           ///< by id
  std::unordered_map<std::string_view, std::uint32_t> ids;  ///< of names
  std::uint32_t begin = 0, end = 0, pad = 0, unknown = 0;
  std::optional<std::uint32_t> mask;
};

}  // namespace enfilade::models

namespace enfilade::models::vocabularies {

/// As Subwords' functions of like names.
std::shared_ptr<const Subwords::Pieces> word_pieces(std::string_view text,
                                                    const std::string& origin, Letters letters);
std::shared_ptr<const Subwords::Pieces> sentence_pieces(std::string_view bytes,
                                                        const std::string& origin);

}  // namespace enfilade::models::vocabularies
