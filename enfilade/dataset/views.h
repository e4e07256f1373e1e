/// \file  Single pictures of a data set, by the names of scan and viewpoint.
///
/// For figures, pages and first steps. To render many views, make a render::Renderer of
/// Dataset::faces(), and render them in batches into your own memory.
#pragma once
#include <cstdint>
#include <string>

#include "enfilade/dataset/dataset.h"
#include "enfilade/geometry/camera.h"
#include "enfilade/image/image.h"
#include "enfilade/render/renderer.h"

namespace enfilade::dataset {

/// Viewpoint and direction of a view.
struct NamedView {
  std::string scan;
  std::string viewpoint;   ///< id
  Radians heading = {};    ///< clockwise from world +y
  Radians elevation = {};  ///< in [-pi/2, pi/2], up positive
};

/// The same by indices. \throws LookupError naming the unknown or excluded one; as graphs()
render::View find_view(const Dataset& dataset, const NamedView& view);

/// Whether there is a colour panorama of the viewpoint. \pre viewpoint is one of the scan's
/// \throws FileError, InvalidInput for broken files
bool has_colour(const Dataset& dataset, ScanIndex scan, ViewpointIndex viewpoint);

/// RGB, (height, width, 3), drawn on the CPU. Decodes the faces it needs, unless they are in
/// Dataset::faces(). \throws as render::Renderer::render(); with a NamedView, as find_view()
image::Image8 render_colour(const Dataset& dataset, const render::View& view,
                            const Camera& camera = {});
image::Image8 render_colour(const Dataset& dataset, const NamedView& view,
                            const Camera& camera = {});

/// z-depth in quarter millimetres, (height, width); 0: no reading. \throws as render_colour()
image::Image16 render_depth(const Dataset& dataset, const render::View& view,
                            const Camera& camera = {});
image::Image16 render_depth(const Dataset& dataset, const NamedView& view,
                            const Camera& camera = {});

/// Ids of object instances, (height, width); 0: none. \throws as render_colour()
image::Image32 render_instances(const Dataset& dataset, const render::View& view,
                                const Camera& camera = {});

/// All directions in RGB, (width / 2, width, 3), equirectangular. The middle column is at the
/// heading, the middle row at the horizon.
/// \throws as render_colour(); ArgumentError for a width below 2
image::Image8 render_panorama(const Dataset& dataset, const render::View& view,
                              std::uint32_t width = 1024);
image::Image8 render_panorama(const Dataset& dataset, const NamedView& view,
                              std::uint32_t width = 1024);

}  // namespace enfilade::dataset
