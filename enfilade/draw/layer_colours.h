/// \file  Layers of a rendered picture in colours for people.
#pragma once
#include <filesystem>
#include <vector>

#include "enfilade/draw/colour_maps.h"
#include "enfilade/image/image.h"
#include "enfilade/render/pictures.h"
#include "enfilade/scan/panorama_source.h"

namespace enfilade::draw {

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
