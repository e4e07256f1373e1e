/// \file  mpcat40: the object categories of Matterport3D, by number.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace enfilade::mesh {

/// One category, as Matterport3D's label tables (mpcat40.tsv, category_mapping.tsv) have it.
struct Mpcat40 {
  /// The numbers: what Object::category and class pictures hold.
  enum Category : std::uint16_t {
    kVoid,
    kWall,
    kFloor,
    kChair,
    kDoor,
    kTable,
    kPicture,
    kCabinet,
    kCushion,
    kWindow,
    kSofa,
    kBed,
    kCurtain,
    kChestOfDrawers,
    kPlant,
    kSink,
    kStairs,
    kCeiling,
    kToilet,
    kStool,
    kTowel,
    kMirror,
    kTvMonitor,
    kShower,
    kColumn,
    kBathtub,
    kCounter,
    kFireplace,
    kLighting,
    kBeam,
    kRailing,
    kShelving,
    kBlinds,
    kGymEquipment,
    kSeating,
    kBoardPanel,
    kFurniture,
    kAppliances,
    kClothes,
    kObjects,
    kMisc,
    kUnlabeled,
  };

  std::string_view name;  ///< "chest_of_drawers"
  std::int32_t row;       ///< of category_mapping.tsv: the raw category that fits best
  std::string_view raw;   ///< the name of that: "chest of drawers"
};

inline constexpr std::size_t kMpcat40Size = 42;  ///< categories, from void to unlabeled

/// O(1). \pre category < kMpcat40Size
const Mpcat40& mpcat40(std::size_t category);

/// The name, "chest_of_drawers" for 13; "unknown" for numbers from kMpcat40Size on.
std::string_view class_name(std::size_t category) noexcept;

}  // namespace enfilade::mesh
