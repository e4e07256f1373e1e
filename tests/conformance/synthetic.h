/// \file  Inputs that are formulas, so that recordings need not hold them: SYNTHETIC features of
/// views and objects, and ids of words.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade::tests {

/// FNV-1a over the bytes, 64 bits.
std::uint64_t name_hash(std::string_view bytes) noexcept;
/// Number i of a name: in [-1, 1), a multiple of 2^-23.
float synthetic_value(std::string_view name, std::uint64_t i) noexcept;

/// The numbers of a view, 0..35, of a viewpoint. \param out columns, at most 65,536
void synthetic_view(std::string_view scan, std::string_view viewpoint, std::uint32_t view,
                    std::span<float> out);
/// The numbers of an object that is seen from a viewpoint.
void synthetic_object(std::string_view scan, std::string_view viewpoint, std::string_view object,
                      std::span<float> out);

/// Ids of a text cut at runs of ASCII white space: 1, then 3 + hash mod 297 for each word, then 2;
/// of more than `most` the first are kept.
std::vector<std::int64_t> synthetic_words(std::string_view text, std::size_t most = 100);

}  // namespace enfilade::tests
