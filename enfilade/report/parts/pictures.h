/// \file  Pictures of a data set as `data:` URIs, for a page that names no file.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "enfilade/dataset/dataset.h"
#include "enfilade/render/renderer.h"

namespace enfilade::report::parts {

/// "data:image/jpeg;base64,...". \param type "image/jpeg"
std::string data_uri(std::string_view type, std::string_view bytes);

struct PictureSize {
  std::uint32_t width = 0, height = 0;
};

/// The view as a JPEG; nothing if the viewpoint has no panorama. \throws errors of broken pictures
std::optional<std::string> view_uri(const dataset::Dataset& data, const render::View& view,
                                    PictureSize size);
/// All directions, half as high as wide; the middle column looks along the view's heading.
std::optional<std::string> panorama_uri(const dataset::Dataset& data, const render::View& view,
                                        std::uint32_t width);
/// A sentence for where a picture would be. It names no folder: pages are handed around.
std::string no_pictures_of(std::string_view scan);

}  // namespace enfilade::report::parts
