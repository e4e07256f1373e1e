#include "enfilade/mesh/mpcat40.h"

#include <array>

#include "enfilade/core/check.h"

namespace enfilade::mesh {

const Mpcat40& mpcat40(std::size_t category) {
  // Names: mpcat40.tsv; rows and raw names: category_mapping.tsv.
  static constexpr std::array<Mpcat40, kMpcat40Size> kCategories{{
      {"void", 9, "remove"},
      {"wall", 1, "wall"},
      {"floor", 4, "floor"},
      {"chair", 7, "chair"},
      {"door", 2, "door"},
      {"table", 15, "table"},
      {"picture", 5, "picture"},
      {"cabinet", 13, "cabinet"},
      {"cushion", 37, "cushion"},
      {"window", 6, "window"},
      {"sofa", 103, "sofa"},
      {"bed", 26, "bed"},
      {"curtain", 14, "curtain"},
      {"chest_of_drawers", 213, "chest of drawers"},
      {"plant", 16, "plant"},
      {"sink", 22, "sink"},
      {"stairs", 78, "stairs"},
      {"ceiling", 3, "ceiling"},
      {"toilet", 28, "toilet"},
      {"stool", 33, "stool"},
      {"towel", 21, "towel"},
      {"mirror", 20, "mirror"},
      {"tv_monitor", 38, "tv"},
      {"shower", 182, "shower"},
      {"column", 30, "column"},
      {"bathtub", 55, "bathtub"},
      {"counter", 66, "counter"},
      {"fireplace", 52, "fireplace"},
      {"lighting", 12, "light"},
      {"beam", 59, "beam"},
      {"railing", 106, "railing"},
      {"shelving", 171, "shelving"},
      {"blinds", 127, "blinds"},
      {"gym_equipment", 224, "gym equipment"},
      {"seating", 49, "bench"},
      {"board_panel", 204, "panel"},
      {"furniture", 229, "furniture"},
      {"appliances", 87, "refrigerator"},
      {"clothes", 53, "clothes"},
      {"objects", 186, "objects"},
      {"misc", 751, "misc"},
      {"unlabeled", 40, "unknown"},
  }};
  EN_CHECK_LT(category, kCategories.size());
  return kCategories[category];
}

std::string_view class_name(std::size_t category) noexcept {
  return category < kMpcat40Size ? mpcat40(category).name : "unknown";
}

}  // namespace enfilade::mesh
