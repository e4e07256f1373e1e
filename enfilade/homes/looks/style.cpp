#include "enfilade/homes/looks/style.h"

#include <algorithm>
#include <map>
#include <span>
#include <string_view>
#include <utility>

#include "enfilade/homes/plan/draws.h"
#include "enfilade/image/textures.h"
#include "enfilade/image/tone.h"

namespace enfilade::homes::looks {
namespace {

using image::Rgb;
using plan::is_one_of;

struct NamedColour {
  std::string_view name;
  Rgb value;
};

// Colours of walls, the most usual first; all names differ.
constexpr NamedColour kWallColours[] = {
    {"white", {0.93, 0.92, 0.90}},       {"cream", {0.93, 0.88, 0.76}},
    {"light grey", {0.78, 0.79, 0.80}},  {"beige", {0.84, 0.76, 0.64}},
    {"light blue", {0.68, 0.79, 0.87}},  {"light green", {0.74, 0.83, 0.71}},
    {"yellow", {0.93, 0.84, 0.55}},      {"dark blue", {0.22, 0.31, 0.46}},
    {"olive green", {0.52, 0.53, 0.36}}, {"terracotta", {0.76, 0.47, 0.35}},
    {"pink", {0.90, 0.74, 0.73}},        {"lilac", {0.76, 0.70, 0.84}}};
constexpr NamedColour kAccentColours[] = {
    {"red", {0.72, 0.14, 0.13}},    {"dark blue", {0.13, 0.20, 0.42}},
    {"green", {0.23, 0.48, 0.28}},  {"orange", {0.86, 0.47, 0.16}},
    {"grey", {0.50, 0.51, 0.53}},   {"turquoise", {0.15, 0.55, 0.56}},
    {"purple", {0.43, 0.22, 0.49}}, {"beige", {0.82, 0.74, 0.60}}};
constexpr NamedColour kFabricColours[] = {
    {"grey", {0.52, 0.53, 0.55}},       {"dark blue", {0.17, 0.24, 0.40}},
    {"beige", {0.80, 0.72, 0.60}},      {"green", {0.27, 0.42, 0.30}},
    {"brown", {0.40, 0.26, 0.17}},      {"red", {0.62, 0.17, 0.16}},
    {"light blue", {0.55, 0.68, 0.80}}, {"mustard yellow", {0.80, 0.62, 0.22}},
    {"black", {0.13, 0.13, 0.14}},      {"pink", {0.84, 0.58, 0.60}}};
constexpr NamedColour kWoods[] = {
    {"light brown", {0.75, 0.57, 0.37}},   {"brown", {0.55, 0.36, 0.21}},
    {"dark brown", {0.34, 0.22, 0.15}},    {"white", {0.90, 0.89, 0.86}},
    {"reddish brown", {0.52, 0.26, 0.16}}, {"grey", {0.62, 0.59, 0.55}}};
constexpr NamedColour kTiles[] = {{"white", {0.92, 0.93, 0.92}},
                                  {"light blue", {0.62, 0.77, 0.84}},
                                  {"green", {0.45, 0.62, 0.52}},
                                  {"beige", {0.85, 0.78, 0.67}}};
constexpr NamedColour kCarpets[] = {{"beige", {0.75, 0.68, 0.57}},
                                    {"grey", {0.55, 0.55, 0.56}},
                                    {"light grey", {0.72, 0.71, 0.69}},
                                    {"dark blue", {0.25, 0.30, 0.40}}};
constexpr NamedColour kMetals[] = {
    {"silver", {0.72, 0.72, 0.73}}, {"golden", {0.80, 0.63, 0.33}}, {"black", {0.12, 0.12, 0.13}}};
constexpr NamedColour kPaints[] = {{"red", {0.70, 0.16, 0.14}},    {"blue", {0.18, 0.34, 0.62}},
                                   {"green", {0.22, 0.47, 0.27}},  {"yellow", {0.92, 0.76, 0.24}},
                                   {"orange", {0.87, 0.48, 0.18}}, {"purple", {0.42, 0.25, 0.50}},
                                   {"cream", {0.91, 0.87, 0.77}},  {"brown", {0.42, 0.29, 0.19}}};

Vec3f linear(Rgb c) {
  return to_float(
      {image::linear_from_srgb(c.r), image::linear_from_srgb(c.g), image::linear_from_srgb(c.b)});
}

/// Adds materials, whose textures are drawn from one stream.
struct Palette {
  mesh::MeshBuilder& builder;
  Rng rng;
  HomeSurfaces surfaces;

  NamedMaterial add(mesh::Material m, double size, std::string_view colour,
                    std::string_view material) {
    m.name = std::string(colour) + " " + std::string(material);
    return {builder.add_material(std::move(m), size), std::string(colour), std::string(material)};
  }
  NamedMaterial textured(const image::Texture& texture, double size, std::string_view colour,
                         std::string_view material, float mirror = 0) {
    mesh::Material m;
    m.colour = {1, 1, 1};
    if (surfaces == HomeSurfaces::kTextured) m.texture = texture();
    m.mirror = mirror;
    return add(std::move(m), size, colour, material);
  }
  NamedMaterial tiled(const image::Texture& texture, double size, std::string_view colour) {
    return textured(texture, size, colour, "tiled", 0.03F);
  }
  NamedMaterial plain(Rgb value, std::string_view colour, std::string_view material,
                      float mirror = 0, Vec3f emission = {}) {
    mesh::Material m;
    m.colour = linear(value);
    m.mirror = mirror;
    m.emission = emission;
    return add(std::move(m), 1, colour, material);
  }
  /// The colours in a random order, the first `keep` in their own.
  std::vector<NamedColour> shuffled(std::span<const NamedColour> all, std::size_t keep = 0) {
    std::vector<NamedColour> colours(all.begin(), all.end());
    rng.shuffle(std::span(colours).subspan(keep));
    return colours;
  }
};

/// What the rooms of a home choose from.
struct HomeMaterials {
  std::vector<NamedMaterial> walls, wet_walls, features, fabrics, accents, rugs, pictures;
  NamedMaterial planks, carpet, carpet2, kitchen_tiles, bath_tiles, bath_tiles2, rough;
  RoomStyle common;
};

NamedMaterial make_wall(Palette& palette, const NamedColour& colour, std::size_t i) {
  using image::Paper;
  const Rgb c = colour.value;
  if (i % 3 != 2) {
    return palette.textured(image::plaster(palette.rng, c), 1.2, colour.name, "painted");
  }
  const auto paper = static_cast<Paper>(palette.rng.below(4));
  const bool dark = c.r + c.g + c.b < 1.5;
  const Rgb motif = image::mix(c, dark ? Rgb{0.9, 0.82, 0.6} : Rgb{0.45, 0.4, 0.35}, 0.24);
  const double size = paper == Paper::kDots ? 0.6 : 0.9;
  return palette.textured(image::wallpaper(palette.rng, c, motif, paper), size, colour.name,
                          "papered");
}

void make_walls(Palette& palette, HomeMaterials& home, std::size_t rooms) {
  // Nearly all homes have white and cream; their other colours differ.
  const auto colours = palette.shuffled(kWallColours, 2);
  const std::size_t n = std::clamp<std::size_t>(rooms / 2 + 4, 6, 9);
  for (std::size_t i = 0; i < n; ++i) home.walls.push_back(make_wall(palette, colours[i], i));
  palette.rng.shuffle(std::span(home.walls));
  const auto tiles = palette.shuffled(kTiles);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [name, c] = tiles[i];
    const Rgb grout = image::mix(c, {0.55, 0.55, 0.55}, 0.45);
    home.wet_walls.push_back(
        i % 2 == 0 ? palette.tiled(image::bricks(palette.rng, c, grout, 8, 0.25), 0.9, name)
                   : palette.tiled(image::tiles(palette.rng, c, c, grout, 5), 1, name));
  }
  const auto brick = image::bricks(palette.rng, {0.62, 0.33, 0.24}, {0.74, 0.71, 0.66}, 12, 1);
  home.features.push_back(palette.textured(brick, 1, "red", "brick"));
  const Rgb green{0.25, 0.36, 0.33}, pale{0.62, 0.62, 0.45};
  const auto leaves = image::wallpaper(palette.rng, green, pale, image::Paper::kLeaves);
  home.features.push_back(palette.textured(leaves, 1, "dark green", "papered"));
}

void make_floors(Palette& palette, HomeMaterials& home) {
  Rng& rng = palette.rng;
  constexpr std::size_t kUsual[] = {0, 1, 2, 5};
  const NamedColour& tone = kWoods[kUsual[rng.below(4)]];
  home.planks =
      rng.below(3) != 0
          ? palette.textured(image::planks(rng, tone.value, 8), 1.1, tone.name, "wooden", 0.02F)
          : palette.textured(image::parquet(rng, tone.value, 4), 1.2, tone.name, "parquet", 0.02F);
  const auto carpets = palette.shuffled(kCarpets);
  const auto carpet = [&](const NamedColour& c) {
    return palette.textured(image::carpet(rng, c.value), 0.7, c.name, "carpeted");
  };
  home.carpet = carpet(carpets[0]);
  home.carpet2 = carpet(carpets[1]);
  const Rgb white{0.88, 0.87, 0.85}, dark{0.28, 0.29, 0.31}, sand{0.78, 0.70, 0.58};
  const Rgb grout{0.55, 0.53, 0.50};
  home.kitchen_tiles =
      rng.below(2) == 0
          ? palette.tiled(image::tiles(rng, sand, sand, grout, 3), 1, "beige")
          : palette.tiled(image::tiles(rng, white, dark, grout, 4), 1.2, "black and white");
  const Rgb grey{0.62, 0.64, 0.66}, grey2{0.66, 0.68, 0.70}, dark_grout{0.45, 0.45, 0.45};
  home.bath_tiles = palette.tiled(image::tiles(rng, grey, grey2, dark_grout, 4), 1.2, "grey");
  const auto marble = image::marble(rng, {0.88, 0.87, 0.85}, {0.50, 0.48, 0.46});
  home.bath_tiles2 = palette.textured(marble, 1.4, "white", "marble", 0.05F);
  home.rough = palette.textured(image::concrete(rng, {0.60, 0.59, 0.57}), 1.6, "grey", "concrete");
}

void make_fabrics(Palette& palette, HomeMaterials& home, std::size_t rooms) {
  using image::Weave;
  Rng& rng = palette.rng;
  const auto colours = palette.shuffled(kFabricColours);
  const std::size_t n = std::clamp<std::size_t>(rooms / 2 + 3, 5, 8);
  for (std::size_t i = 0; i < n; ++i) {
    const auto [name, c] = colours[i];
    if (name == "brown" || name == "black") {
      home.fabrics.push_back(palette.textured(image::leather(rng, c), 0.4, name, "leather", 0.03F));
      continue;
    }
    const auto weave = static_cast<Weave>(rng.below(5) < 3 ? 0 : 1 + rng.below(2));
    const Rgb second = image::mix(c, {0.95, 0.93, 0.88}, 0.45);
    const auto fabric = image::fabric(rng, c, second, weave);
    home.fabrics.push_back(palette.textured(fabric, 0.35, name, "fabric"));
  }
  const auto accents = palette.shuffled(kAccentColours);
  const std::size_t most = std::clamp<std::size_t>(rooms / 2 + 3, 6, accents.size());
  for (std::size_t i = 0; i < most; ++i) {
    const auto [name, c] = accents[i];
    const Rgb pale = image::mix(c, {0.95, 0.92, 0.84}, 0.72);
    const Rgb deep = image::shade(image::mix(c, {0.2, 0.12, 0.1}, 0.45), 0.9);
    const auto weave = rng.below(3) == 0 ? Weave::kStriped : Weave::kPlain;
    const auto fabric = image::fabric(rng, c, image::mix(c, pale, 0.35), weave);
    home.accents.push_back(palette.textured(fabric, 0.4, name, "fabric"));
    const auto rug = image::rug(rng, c, pale, deep, static_cast<image::Rug>(i % 4));
    home.rugs.push_back(palette.textured(rug, 0, name, ""));
  }
}

void make_common(Palette& palette, RoomStyle& common) {
  Rng& rng = palette.rng;
  const auto woods = palette.shuffled(kWoods);
  const auto wood = [&](const NamedColour& c) {
    return palette.textured(image::wood(rng, c.value), 0.9, c.name, "wooden", 0.02F);
  };
  common.wood = wood(woods[0]);
  common.wood2 = wood(woods[1]);
  const NamedColour& metal = kMetals[rng.below(3)];
  const float mirror = metal.name == "black" ? 0.05F : 0.25F;
  common.metal = palette.plain(metal.value, metal.name, "metal", mirror);
  common.steel = palette.plain({0.70, 0.71, 0.72}, "silver", "metal", 0.2F);
  common.ceiling = palette.plain({0.93, 0.925, 0.91}, "white", "");
  common.trim =
      rng.below(3) != 0 ? palette.plain({0.92, 0.915, 0.90}, "white", "wooden") : common.wood;
  const bool dark = rng.below(2) == 0;
  const auto marble = dark ? image::marble(rng, {0.20, 0.20, 0.21}, {0.62, 0.61, 0.60})
                           : image::marble(rng, {0.87, 0.86, 0.84}, {0.45, 0.44, 0.45});
  common.stone = palette.textured(marble, 1.1, dark ? "black" : "white", "marble", 0.06F);
  common.white = palette.plain({0.93, 0.93, 0.92}, "white", "", 0.03F);
  common.glass = palette.plain({0.72, 0.80, 0.80}, "", "glass", 0.15F);
  common.black = palette.plain({0.10, 0.10, 0.11}, "black", "", 0.03F);
  common.linen =
      palette.textured(image::fabric(rng, {0.93, 0.92, 0.89}, {}, {}), 0.35, "white", "fabric");
  common.leaf = palette.plain({0.24, 0.43, 0.20}, "green", "");
  common.leaf2 = palette.plain({0.38, 0.55, 0.26}, "green", "");
  common.pot = palette.plain({0.68, 0.40, 0.28}, "terracotta", "clay");
  common.shade = palette.plain({0.95, 0.90, 0.78}, "cream", "fabric", 0, {1.5F, 1.15F, 0.75F});
  common.glow = palette.plain({0.97, 0.96, 0.94}, "white", "glass", 0, {3.2F, 2.9F, 2.4F});
  common.mirror = palette.plain({0.96, 0.97, 0.97}, "", "glass", 0.92F);
  common.screen = palette.plain({0.08, 0.09, 0.11}, "black", "", 0.10F);
  for (const NamedColour& c : kPaints) common.paints.push_back(palette.plain(c.value, c.name, ""));
}

NamedMaterial floor_of(const HomeMaterials& home, HomeKind kind, char type, std::size_t k) {
  if (is_one_of(type, "atS")) return k % 2 == 0 ? home.bath_tiles : home.bath_tiles2;
  if (is_one_of(type, "kj")) return home.kitchen_tiles;
  if (is_one_of(type, "gupxyZ")) return home.rough;
  if (is_one_of(type, "w")) return home.carpet2;
  if (kind == HomeKind::kOffice && is_one_of(type, "omhCn")) return home.carpet;
  if (kind == HomeKind::kHotelFloor && is_one_of(type, "bh")) {
    return type == 'h' ? home.carpet2 : home.carpet;
  }
  if (type == 'b' && k % 3 == 2) return home.carpet;
  return home.planks;
}

/// The k-th room of its type.
RoomStyle room_style(const HomeMaterials& home, HomeKind kind, char type, std::size_t k,
                     std::size_t shift, Rng& rng) {
  RoomStyle style = home.common;
  const auto& walls = is_one_of(type, "atS") ? home.wet_walls : home.walls;
  // The k-th room has wall k and an accent that moves on by one whenever the walls come round
  // again: pairs repeat only after walls * accents rooms of a type.
  const std::size_t w = k % walls.size(), accents = home.accents.size();
  const std::size_t a = (w + k / walls.size() + shift) % accents;
  style.wall = walls[(w + shift) % walls.size()];
  style.feature_wall = style.wall;
  if (is_one_of(type, "bldfno") && rng.below(4) == 0) {
    style.feature_wall = home.features[rng.below(home.features.size())];
  }
  style.floor = floor_of(home, kind, type, k);
  style.accent = home.accents[a];
  style.rug = home.rugs[a];
  const std::size_t f = (k + rng.below(home.fabrics.size())) % home.fabrics.size();
  style.fabric = home.fabrics[f];
  style.fabric2 = home.fabrics[(f + 1 + rng.below(home.fabrics.size() - 1)) % home.fabrics.size()];
  style.pictures = home.pictures;
  rng.shuffle(std::span(style.paints));
  return style;
}

}  // namespace

std::vector<RoomStyle> make_styles(const Plan& plan, mesh::MeshBuilder& builder,
                                   HomeSurfaces surfaces) {
  constexpr std::uint64_t kStream = 0x5354594C45;  // "STYLE"
  Palette palette{builder, Rng(plan.seed, kStream), surfaces};
  HomeMaterials home;
  const std::size_t rooms = plan.rooms.size();
  make_walls(palette, home, rooms);
  make_floors(palette, home);
  make_fabrics(palette, home, rooms);
  make_common(palette, home.common);
  const std::size_t paintings = std::clamp<std::size_t>(rooms, 6, 12);
  const auto painting = [&] { return paint_picture(palette.rng, 128, 96); };
  for (std::size_t i = 0; i < paintings; ++i) {
    home.pictures.push_back(palette.textured(painting, 0, "", "painted"));
  }
  std::map<char, std::size_t> seen;
  std::vector<RoomStyle> styles;
  for (std::size_t i = 0; i < rooms; ++i) {
    const char type = plan.rooms[i].type;
    Rng rng(plan.seed, kStream, i + 1);
    const std::size_t shift = static_cast<unsigned char>(type) + plan.seed % 1009;
    RoomStyle style = room_style(home, plan.kind, type, seen[type]++, shift, rng);
    const std::size_t first = (2 * i) % paintings;
    std::rotate(style.pictures.begin(), style.pictures.begin() + static_cast<std::ptrdiff_t>(first),
                style.pictures.end());
    styles.push_back(std::move(style));
  }
  return styles;
}

}  // namespace enfilade::homes::looks
