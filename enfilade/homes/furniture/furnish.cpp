#include "enfilade/homes/furniture/furnish.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "enfilade/homes/furniture/furnish_recipes.h"

namespace enfilade::homes::furniture {
namespace {

void furnish_stairwell(FurnishedRoom& room) {
  hang_pictures(room, 2);
  if (room.area() > 9) plants(room, 1);
  dress_windows(room, false);
  hang_lights(room, Light::kHome);
}

struct Recipe {
  std::string_view types;  ///< Matterport3D's region letters
  void (*furnish)(FurnishedRoom& room);
};

constexpr std::array kRecipes{
    Recipe{"b", furnish_bedroom},
    Recipe{"lfv", [](FurnishedRoom& room) { furnish_living(room, true); }},
    Recipe{"n", [](FurnishedRoom& room) { furnish_living(room, false); }},
    Recipe{"d", furnish_dining},
    Recipe{"D", furnish_booth},
    Recipe{"k", furnish_kitchen},
    Recipe{"a", furnish_bath},
    Recipe{"t", furnish_toilet},
    Recipe{"S", furnish_spa},
    Recipe{"j", furnish_laundry},
    Recipe{"o", furnish_office},
    Recipe{"m", furnish_meeting},
    Recipe{"C", furnish_classroom},
    Recipe{"i", furnish_library},
    Recipe{"e", furnish_entry},
    Recipe{"h", furnish_hallway},
    Recipe{"s", furnish_stairwell},
    Recipe{"c", furnish_closet},
    Recipe{"w", furnish_gym},
    Recipe{"r", furnish_games},
    Recipe{"B", furnish_bar},
    Recipe{"py", [](FurnishedRoom& room) { furnish_outdoors(room, false); }},
    Recipe{"x", [](FurnishedRoom& room) { furnish_outdoors(room, true); }},
    Recipe{"g", [](FurnishedRoom& room) { furnish_storage(room, true); }},
};

}  // namespace

void furnish(const looks::RoomSpace& space, const looks::RoomStyle& style, Rng& rng,
             looks::HomeParts parts) {
  FurnishedRoom room(space, style, rng, parts);
  const auto at = std::find_if(kRecipes.begin(), kRecipes.end(), [&](const Recipe& recipe) {
    return recipe.types.find(space.type) != std::string_view::npos;
  });
  if (at == kRecipes.end()) return furnish_storage(room, false);
  at->furnish(room);
}

std::vector<CatalogueEntry> catalogue() {
  std::vector<CatalogueEntry> entries;
  for (const Shape& shape : all_shapes()) {
    const auto at = std::find_if(entries.begin(), entries.end(),
                                 [&](const CatalogueEntry& e) { return e.noun == shape.noun; });
    if (at == entries.end()) {
      entries.push_back({std::string(shape.noun), shape.category, 1});
    } else {
      ++at->shapes;
    }
  }
  return entries;
}

}  // namespace enfilade::homes::furniture
