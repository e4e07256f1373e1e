/// \file  Pictures as cameras write them: upright by EXIF's orientation, with the fields of a
/// sphere (GPano, in XMP) that panorama cameras add.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/geometry/vec.h"
#include "enfilade/image/codecs.h"

namespace enfilade::image {

/// GPano's fields of a photo. Source: Google, "Photo Sphere XMP Metadata".
struct SphereNotes {
  /// The picture's rectangle in the whole sphere's picture, pixels.
  struct Crop {
    double full_width = 0, full_height = 0;
    double left = 0, top = 0, width = 0, height = 0;
    /// Whether the picture is less than the whole sphere.
    bool is_part() const { return width < full_width || height < full_height; }
  };
  std::string projection;  ///< "equirectangular"; empty: not given
  /// The direction of the picture's middle, degrees clockwise from north, 0 .. 360.
  std::optional<double> heading;
  /// The elevation of the picture's middle, degrees, -90 .. 90.
  double pitch = 0;
  /// Degrees, -180 .. 180. The horizon turns counterclockwise in the picture as it grows.
  double roll = 0;
  std::optional<Crop> crop;

  bool is_level() const { return pitch == 0 && roll == 0; }
};
/// From the panorama frame of a sphere's picture to the level one of the same heading: it undoes
/// pitch and roll.
Mat3d level_from_picture(const SphereNotes& sphere);

/// A picture, and what its file says about it.
struct Photo {
  Image8 picture;  ///< upright
  /// Upright too, in pixels; the picture is smaller if it was reduced.
  std::uint32_t stored_width = 0, stored_height = 0;
  int orientation = 1;  ///< EXIF's, 1 .. 8, which was applied
  SphereNotes sphere;
  /// Harmless oddities of the file, a note on an orientation, GPano's fields that cannot be used.
  std::vector<Diagnostic> findings;
};

/// More pixels than a texture or a panorama of 2048 x 2048 texels a face needs. Such a picture with
/// the copies that its readers make takes less than 1 GB.
inline constexpr std::uint64_t kMostPhotoPixels = std::uint64_t{1} << 26U;

/// A JPEG or PNG with 1 to 4 channels.
/// \param most  pixels. Edges of a larger picture are halved while it is read, by averages, which
/// takes no memory for the whole picture. A finding says so.
/// \throws InvalidInput, also for other content, and for more pixels in a progressive JPEG or an
/// interlaced PNG: they cannot be reduced while they are read
Photo decode_photo(Bytes bytes, const std::string& file, std::uint64_t most = kMostPhotoPixels);
/// A JPEG, PNG or HDR (tone-mapped with that exposure) with 3 channels, recognised by its first
/// bytes.
/// \param most  as for decode_photo(); half of it for HDR, whose pixels are larger
/// \throws FileError; InvalidInput
Photo load_photo(const std::string& path, std::optional<double> exposure = std::nullopt,
                 std::uint64_t most = kMostPhotoPixels);

/// A picture of another format, made upright by its file's EXIF data (TIFF's, with or without
/// "Exif" before them; empty: none). Data that cannot be read say nothing.
/// \param shape  the file's; the picture may be reduced
Photo upright_by_exif(Image8 stored, Bytes exif, const Shape& shape, const std::string& file);

/// The upright picture of one stored with that orientation (EXIF 2.3, tag 0x0112).
/// \pre 1 <= orientation <= 8
Image8 upright(Image8 stored, int orientation);

}  // namespace enfilade::image
