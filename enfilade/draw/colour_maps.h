/// \file  Colour maps for depth, classes and instances, with legends, and for all layers of
/// rendered pictures. Input: pictures of one channel and any size. Output: RGB.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "enfilade/image/image.h"
#include "enfilade/render/renderer.h"
#include "enfilade/scan/panorama_source.h"

namespace enfilade::draw {

/// A colour: red, green, blue, 0 .. 255.
using Rgb = std::array<std::uint8_t, 3>;

/// No depth reading, or no object: a grey that is not close to any other colour here.
inline constexpr Rgb kNothing{128, 128, 128};

/// Viridis reversed: 0 (near) is yellow, 1 (far) dark violet; lightness decreases evenly, also for
/// colour-blind readers and in print. Source: Smith and van der Walt's map for matplotlib (CC0), of
/// which sixteen colours are kept and interpolated: within 7 levels of the original.
/// \param share clamped to [0, 1]
Rgb depth_colour(double share);

/// Number of ids whose colours are chosen: Matterport3D's categories 1 .. 41.
inline constexpr std::uint32_t kChosenColours = 41;

/// A fixed colour for each id. Those of 1 .. kChosenColours are at least 25 apart in CIELAB
/// (CIE76), from each other and from kNothing. Above: hues in steps of the golden ratio, so that
/// consecutive ids differ most. 0 is kNothing.
Rgb id_colour(std::uint32_t id);

/// Upper end of the depth scale for a picture: its largest reading, rounded up to whole metres; 1
/// without readings.
/// \param depth quarter millimetres, 0: no reading
double farthest_depth(const image::Image16& depth);

/// Colours of depth. \param depth quarter millimetres, 0: no reading  \param farthest metres; depth
/// beyond it has its colour
/// \throws ArgumentError if depth has more than one channel, or unless farthest > 0
image::Image8 colour_depth(const image::Image16& depth, double farthest);

/// The distances between which the colours of a depth picture change, metres.
struct DepthRange {
  double nearest = 0;   ///< this and less: depth_colour(0)
  double farthest = 1;  ///< this and more: depth_colour(1)
};

/// The range of most readings of some pictures, from their 5th to their 95th percentile. It is
/// rounded outwards to decimetres, and at least half a metre long. {0, 1} without readings.
/// \param depth quarter millimetres, 0: no reading
DepthRange depth_range(std::span<const image::Image16> depth);

/// Colours of depth within a range. \param depth as above
/// \throws ArgumentError if depth has more than one channel, or unless nearest < farthest
image::Image8 colour_depth(const image::Image16& depth, const DepthRange& range);

/// Colours of ids. \throws ArgumentError for more than one channel (here and below)
image::Image8 colour_ids(const image::Image16& ids);
image::Image8 colour_ids(const image::Image32& ids);

/// Number of pixels with an id.
struct IdArea {
  std::uint32_t id = 0;
  std::size_t pixels = 0;
  friend constexpr bool operator==(IdArea, IdArea) = default;
};
/// The ids in a picture, without 0, largest area first, ties by id.
std::vector<IdArea> count_ids(const image::Image16& ids);
std::vector<IdArea> count_ids(const image::Image32& ids);

/// Names of ids that have one.
using IdNames = std::map<std::uint32_t, std::string>;

/// The picture with a legend below: a colour bar from 0 to `farthest` metres, and kNothing.
/// \pre picture has 3 channels (here and below)
image::Image8 with_depth_legend(const image::Image8& picture, double farthest);
/// The picture with a legend below: colours and names of the ids, in their order, in at most twelve
/// rows. Then the number of those left out.
image::Image8 with_id_legend(const image::Image8& picture, std::span<const IdArea> ids,
                             const IdNames& names);

/// Colours of each layer of some pictures, and the legends to them: one scale for all views in
/// them.
class LayerColours {
 public:
  /// \param class_names of mpcat40, as load_class_names() reads them; may be empty
  explicit LayerColours(const render::Pictures& pictures, IdNames class_names = {});
  /// RGB; colour as it is. \pre the pictures of the constructor, or a part of them
  image::Image8 coloured(const render::Pictures& pictures, scan::Layer layer) const;
  /// `picture`, made of coloured() ones, with the layer's legend below.
  image::Image8 with_legend(const image::Image8& picture, scan::Layer layer) const;

 private:
  double farthest_;  // metres
  std::vector<IdArea> classes_, instances_;
  IdNames class_names_;
};

/// Reads Matterport3D's `mpcat40.tsv`: index and name in the first two columns, their names in the
/// first line. \throws FileError; InvalidInput naming the line
IdNames load_class_names(const std::filesystem::path& file);

}  // namespace enfilade::draw
