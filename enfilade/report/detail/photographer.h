/// \file  Pictures of a data set as `data:` URIs, for a page that names no file.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "enfilade/core/ids.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/render/renderer.h"

namespace enfilade::report::detail {

/// "data:image/jpeg;base64,...". \param type "image/jpeg"
std::string data_uri(std::string_view type, std::string_view bytes);

struct PictureSize {
  std::uint32_t width = 0, height = 0;
};

/// Draws panoramas of a data set, if it has them. One thread.
class Photographer {
 public:
  explicit Photographer(std::shared_ptr<const scan::PanoramaSet> panoramas);

  /// The view as a JPEG; nothing if the scan has no pictures. \throws errors of broken pictures
  std::optional<std::string> view(std::string_view scan, ViewpointIndex viewpoint, Radians heading,
                                  Radians elevation, PictureSize size);
  /// All directions; the middle column looks along `heading`.
  std::optional<std::string> panorama(std::string_view scan, ViewpointIndex viewpoint,
                                      Radians heading, PictureSize size);
  /// A sentence: why the last picture that could not be had could not.
  const std::string& why_not() const { return why_not_; }

 private:
  std::optional<ScanIndex> find(std::string_view scan, ViewpointIndex viewpoint);

  std::shared_ptr<const scan::PanoramaSet> panoramas_;
  std::shared_ptr<render::FaceCache> faces_;
  std::unique_ptr<render::Renderer> renderer_;
  std::string why_not_;
};

}  // namespace enfilade::report::detail
