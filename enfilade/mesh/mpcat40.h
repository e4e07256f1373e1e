/// \file  Matterport3D's 40 categories, as its label tables have them.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace enfilade::mesh {

/// How many classes there are, 0 (void) counted.
inline constexpr std::size_t kMpcat40Size = 42;

/// One class.
struct Mpcat40 {
  std::string_view name;  ///< "chest_of_drawers"
  std::int32_t row;       ///< of category_mapping.tsv: the raw category that says it best
  std::string_view raw;   ///< its name: "chest of drawers"
};
/// 0 void, 1 wall, ... 41 unlabeled. \pre category < kMpcat40Size
const Mpcat40& mpcat40(std::size_t category);

/// The name, "chest_of_drawers" for 13; "unknown" for numbers from kMpcat40Size on.
std::string_view class_name(std::size_t category) noexcept;

}  // namespace enfilade::mesh
