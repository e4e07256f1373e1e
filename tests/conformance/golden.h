/// \file  Pictures that the old simulator rendered, compared with ours of the same poses.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/geometry/camera.h"
#include "enfilade/image/image.h"
#include "enfilade/render/renderer.h"

namespace enfilade::tests {

/// One picture of a `golden.json`.
struct GoldenPose {
  std::string scan, viewpoint;
  Camera camera;
  Radians heading, elevation;
  std::string rgb, depth;  ///< file names beside it
};

/// Reads `<folder>/golden.json`: {"items": [{"rgb", "depth", "scanId", "viewpointId", "width",
/// "height", "vfov", "heading", "elevation"}, ...]}, angles in radians.
/// \throws FileError; InvalidInput with JSON paths
std::vector<GoldenPose> load_golden(const std::filesystem::path& folder);
std::vector<GoldenPose> parse_golden(std::string_view json, const std::string& name);

/// How two colour pictures differ, in levels of 0 .. 255.
struct ColourDifference {
  std::size_t pixels = 0;
  std::uint64_t sum = 0;                              ///< over pixels and channels
  int largest = 0;                                    ///< of a channel
  std::size_t above_1 = 0, above_2 = 0, above_8 = 0;  ///< pixels whose largest is more

  double mean() const;                   ///< over pixels and channels
  double share(std::size_t some) const;  ///< of the pixels
  ColourDifference& operator+=(const ColourDifference& other);
};
/// How two depth pictures differ, in quarter millimetres.
struct DepthDifference {
  std::size_t pixels = 0, identical = 0;
  int largest = 0;

  double share() const;  ///< of the pixels that are identical
  DepthDifference& operator+=(const DepthDifference& other);
};

/// \pre pictures are alike in size and channels
ColourDifference compare(const image::Image8& ours, const image::Image8& golden);
DepthDifference compare(const image::Image16& ours, const image::Image16& golden);

/// What counts as equal.
struct GoldenTolerances {
  /// OpenGL filters with weights of 8 bits and rounds; an exact bilinear filter differs from
  /// llvmpipe's by 0.18 levels on average, another JPEG decoder adds to it.
  double mean = 0.3;
  /// Both roundings at once: the weights' and the decoder's. Few pixels are further off: there one
  /// takes the neighbouring face, where a ray meets the edge between two.
  int usual = 2;
  double usual_share = 0.9999;
  /// Across an edge between faces the colour jumps by what differs between their last texels.
  int most = 8;
  /// Depth takes the nearest texel, and is rounded to steps of 257: rays that meet the boundary of
  /// two texels, or values in the middle of two steps, go either way.
  double identical_share = 0.999;
};
bool within(const GoldenTolerances& t, const ColourDifference& colour,
            const DepthDifference& depth);

/// Our picture of a pose, as the old simulator would draw it.
struct GoldenPicture {
  image::Image8 colour;
  image::Image16 depth;  ///< quarter millimetres
};
/// \param renderer legacy, of `panoramas`  \throws as Renderer::render(); LookupError
GoldenPicture render_golden(render::Renderer& renderer, const scan::PanoramaSet& panoramas,
                            const GoldenPose& pose);
/// Reads a pose's pictures. \throws FileError; InvalidInput, also for another size than the pose's
GoldenPicture load_pictures(const std::filesystem::path& folder, const GoldenPose& pose);

/// Ours, the golden one and what differs (32 times as strong, for colour; black where depth is
/// identical) side by side.
image::Image8 side_by_side(const image::Image8& ours, const image::Image8& golden);
image::Image8 side_by_side(const image::Image16& ours, const image::Image16& golden);

}  // namespace enfilade::tests
