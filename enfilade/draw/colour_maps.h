/// \file  Depth, classes and instances in colours that people can read, with a legend below.
///
/// Pictures in: one channel, any size. Pictures out: RGB.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "enfilade/image/image.h"

namespace enfilade::draw {

using Rgb = std::array<std::uint8_t, 3>;

/// Where there is no depth reading, or no object: a grey, which no other colour here is near.
inline constexpr Rgb kNothing{128, 128, 128};

/// Viridis backwards: 0 (near) is yellow, 1 (far) is dark violet; evenly darker on the way, also to
/// colour-blind eyes and in print. Source: Smith and van der Walt's map for matplotlib (CC0), of
/// which we keep sixteen colours and mix between them: within 7 levels of its 256.
/// \param share clamped to [0, 1]
Rgb depth_colour(double share);

/// The same colour for the same id everywhere: hues a golden ratio apart, so that ids which follow
/// each other differ most. 0 is kNothing.
Rgb id_colour(std::uint32_t id);

/// What depth_colour(1) should stand for in these pictures: their largest reading, metres, rounded
/// up to a whole one; 1 if there is none. \param depth quarter millimetres, 0: no reading
double farthest_depth(const image::Image16& depth);

/// \param depth quarter millimetres, 0: no reading  \param farthest metres; what is beyond it has
/// its colour
/// \throws ArgumentError if depth has more than one channel, or unless farthest > 0
image::Image8 colour_depth(const image::Image16& depth, double farthest);

/// \throws ArgumentError for more than one channel (here and below)
image::Image8 colour_ids(const image::Image16& ids);
image::Image8 colour_ids(const image::Image32& ids);

/// How much of a picture an id takes.
struct IdArea {
  std::uint32_t id = 0;
  std::size_t pixels = 0;
  friend constexpr bool operator==(IdArea, IdArea) = default;
};
/// Those in a picture, 0 left out, largest first, equal ones by id.
std::vector<IdArea> count_ids(const image::Image16& ids);
std::vector<IdArea> count_ids(const image::Image32& ids);

/// Names of ids, where they are known.
using IdNames = std::map<std::uint32_t, std::string>;

/// The picture with a bar from 0 to `farthest` metres and the colour of no reading below it.
/// \pre picture has 3 channels (here and below)
image::Image8 with_depth_legend(const image::Image8& picture, double farthest);
/// The picture with the ids' colours and names below it, in their order; as many as fit twelve
/// rows, then how many more there are.
image::Image8 with_id_legend(const image::Image8& picture, std::span<const IdArea> ids,
                             const IdNames& names);

}  // namespace enfilade::draw
