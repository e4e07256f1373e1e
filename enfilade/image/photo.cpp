#include "enfilade/image/photo.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/file.h"
#include "enfilade/core/numbers.h"
#include "enfilade/core/written_lists.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/image/detail/libjpeg.h"
#include "enfilade/image/detail/photo_notes.h"

namespace enfilade::image {
namespace {

// Incompressible pictures of the largest size that cameras write have less.
constexpr std::size_t kMostPhotoBytes = std::size_t{1} << 30U;

// Grey becomes three equal channels, an alpha channel is dropped.
Image8 to_rgb(Image8 picture) {
  if (picture.channels == 3) return picture;
  Image8 rgb(picture.width, picture.height, 3);
  const std::size_t step = picture.channels < 3 ? 0 : 1;
  const std::uint8_t* from = picture.pixels.data();
  for (std::size_t i = 0; i < rgb.pixels.size(); i += 3, from += picture.channels) {
    for (std::size_t c = 0; c < 3; ++c) rgb.pixels[i + c] = from[c * step];
  }
  return rgb;
}

// --- GPano -----------------------------------------------------------------------------------

// Fields of an XMP packet. Each is an attribute (GPano:Name="value") or an element
// (<GPano:Name>value</GPano:Name>); all writers use that prefix.
class SphereReader {
 public:
  SphereReader(std::string_view xmp, const std::string& file, std::vector<Diagnostic>& findings)
      : xmp_(xmp), file_(file), findings_(findings) {}

  SphereNotes read() {
    SphereNotes sphere;
    sphere.projection = text("ProjectionType");
    if (const auto heading = number("PoseHeadingDegrees", -360, 360)) {
      sphere.heading = *heading < 0 ? *heading + 360 : *heading;
    }
    sphere.pitch = number("PosePitchDegrees", -90, 90).value_or(0);
    sphere.roll = number("PoseRollDegrees", -180, 180).value_or(0);
    SphereNotes::Crop crop;
    struct Size {
      const char* name;
      double& value;
    };
    bool all = true;
    for (const Size& one : {Size{"FullPanoWidthPixels", crop.full_width},
                            {"FullPanoHeightPixels", crop.full_height},
                            {"CroppedAreaLeftPixels", crop.left},
                            {"CroppedAreaTopPixels", crop.top},
                            {"CroppedAreaImageWidthPixels", crop.width},
                            {"CroppedAreaImageHeightPixels", crop.height}}) {
      const auto value = number(one.name, 0, 1e9);
      all = all && value;
      one.value = value.value_or(0);
    }
    if (all && crop.width > 0 && crop.height > 0) sphere.crop = crop;
    return sphere;
  }

 private:
  std::string_view text(std::string_view name) const {
    const std::string wanted = fmt::format("GPano:{}", name);
    for (std::size_t at = xmp_.find(wanted); at != std::string_view::npos;
         at = xmp_.find(wanted, at + 1)) {
      const std::string_view rest = trimmed(xmp_.substr(at + wanted.size()));
      if (rest.starts_with('>')) return trimmed(rest.substr(1, rest.find('<') - 1));
      if (!rest.starts_with('=')) continue;
      const std::string_view value = trimmed(rest.substr(1));
      if (value.empty() || (value[0] != '"' && value[0] != '\'')) continue;
      return trimmed(value.substr(1, value.find(value[0], 1) - 1));
    }
    return {};
  }

  std::optional<double> number(const char* name, double least, double most) {
    std::string_view digits = text(name);
    if (digits.empty()) return std::nullopt;
    if (digits[0] == '+') digits.remove_prefix(1);
    const auto value = parse_number<double>(digits);
    if (value && *value >= least && *value <= most) return value;
    findings_.push_back({Severity::kWarning, file_, fmt::format("GPano:{}", name), "bad-sphere",
                         fmt::format("{:?}, not a number from {} to {}; the field is ignored",
                                     digits.substr(0, 40), least, most)});
    return std::nullopt;
  }

  std::string_view xmp_;
  const std::string& file_;
  std::vector<Diagnostic>& findings_;
};

// --- orientation -----------------------------------------------------------------------------

const char* turn_of(int orientation) {
  constexpr std::array kTurns{"nothing",
                              "mirrored left to right",
                              "turned by half",
                              "mirrored top to bottom",
                              "mirrored along a diagonal",
                              "turned by a quarter clockwise",
                              "mirrored along the other diagonal",
                              "turned by a quarter counterclockwise"};
  return kTurns.at(static_cast<std::size_t>(orientation - 1));
}

void turn(Photo& photo, int orientation, const std::string& file) {
  photo.orientation = orientation;
  if (orientation == 1) return;
  photo.picture = upright(std::move(photo.picture), orientation);
  if (orientation >= 5) std::swap(photo.stored_width, photo.stored_height);
  photo.findings.push_back(
      {Severity::kNote, file, "", "orientation",
       fmt::format("EXIF orientation {}: {}", orientation, turn_of(orientation))});
}

// Before it is turned.
void note_size(Photo& photo, const Shape& stored, const std::string& file) {
  photo.stored_width = stored.width;
  photo.stored_height = stored.height;
  const Image8& picture = photo.picture;
  if (picture.width == stored.width && picture.height == stored.height) return;
  photo.findings.push_back(
      {Severity::kNote, file, "", "reduced-picture",
       fmt::format("{} x {} pixels, reduced to {} x {} while they are read", stored.width,
                   stored.height, picture.width, picture.height)});
}

}  // namespace

void refuse_whole(const char* kind, std::uint32_t width, std::uint32_t height, std::uint64_t most,
                  const std::string& file) {
  refuse(file, "", "too-many-pixels",
         fmt::format("{} of {} x {} pixels; at most {} are allowed, as it cannot be reduced while "
                     "it is read",
                     kind, width, height, most));
}

Image8 upright(Image8 stored, int orientation) {
  EN_CHECK(orientation >= 1 && orientation <= 8);
  if (orientation == 1) return stored;
  // Orientations by what is done: first rows and columns are exchanged, then either is reversed.
  const bool swapped = orientation >= 5;
  const bool across = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool down = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  const std::size_t width = stored.width, height = stored.height;
  Image8 out(swapped ? stored.height : stored.width, swapped ? stored.width : stored.height,
             stored.channels);
  std::uint8_t* to = out.pixels.data();
  for (std::size_t y = 0; y < out.height; ++y) {
    for (std::size_t x = 0; x < out.width; ++x, to += stored.channels) {
      const std::size_t column = swapped ? y : x, row = swapped ? x : y;
      std::copy_n(stored.at(across ? width - 1 - column : column, down ? height - 1 - row : row),
                  stored.channels, to);
    }
  }
  return out;
}

Mat3d level_from_picture(const SphereNotes& sphere) {
  const double p = degrees(sphere.pitch).value, r = degrees(sphere.roll).value;
  // x right, y down, z forward: the roll turns about z, then the pitch about x.
  const Mat3d rolled{{std::cos(r), -std::sin(r), 0, std::sin(r), std::cos(r), 0, 0, 0, 1}};
  const Mat3d pitched{{1, 0, 0, 0, std::cos(p), -std::sin(p), 0, std::sin(p), std::cos(p)}};
  return pitched * rolled;
}

Photo decode_photo(Bytes bytes, const std::string& file, std::uint64_t most) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  Photo photo;
  detail::PhotoNotes notes;
  if (text.starts_with("\xff\xd8")) {
    photo.picture = detail::decode_jpeg(bytes, file, most, &photo.findings);
    notes = detail::jpeg_notes(bytes);
    note_size(photo, jpeg_shape(bytes, file), file);
  } else if (text.starts_with("\x89PNG")) {
    photo.picture = detail::decode_png8(bytes, file, most, &notes);
    note_size(photo, png_shape(bytes, file), file);
  } else {
    refuse(file, "", "unknown-picture", "neither a JPEG nor a PNG");
  }
  turn(photo, notes.orientation, file);
  photo.sphere = SphereReader(notes.xmp, file, photo.findings).read();
  return photo;
}

Photo upright_by_exif(Image8 stored, Bytes exif, const Shape& shape, const std::string& file) {
  detail::PhotoNotes notes;
  detail::read_exif(exif, notes);
  Photo photo;
  photo.picture = std::move(stored);
  note_size(photo, shape, file);
  turn(photo, notes.orientation, file);
  return photo;
}

Photo load_photo(const std::string& path, std::optional<double> exposure, std::uint64_t most) {
  const std::string content = read_file(path, kMostPhotoBytes);
  const std::string_view text = content;
  const Bytes bytes = bytes_of(text);
  if (text.starts_with("#?")) {
    Photo photo;
    Shape stored;
    photo.picture = tone_map(decode_hdr(bytes, path, most / 2, &stored), exposure);
    note_size(photo, stored, path);
    return photo;
  }
  if (!text.starts_with("\xff\xd8") && !text.starts_with("\x89PNG")) {
    refuse(path, "", "unknown-picture",
           text.empty() ? "the file is empty" : "neither JPEG, nor PNG, nor Radiance HDR");
  }
  Photo photo = decode_photo(bytes, path, most);
  photo.picture = to_rgb(std::move(photo.picture));
  return photo;
}

}  // namespace enfilade::image
