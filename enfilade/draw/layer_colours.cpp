#include "enfilade/draw/layer_colours.h"

#include <fmt/format.h>
#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/numbers.h"

namespace enfilade::draw {

using scan::Layer;

LayerColours::LayerColours(const render::Pictures& pictures, IdNames class_names)
    : farthest_(farthest_depth(pictures.depth)),
      classes_(count_ids(pictures.classes)),
      instances_(count_ids(pictures.instances)),
      class_names_(std::move(class_names)) {}

image::Image8 LayerColours::coloured(const render::Pictures& pictures, Layer layer) const {
  switch (layer) {
    case Layer::kColour:
      return pictures.colour;
    case Layer::kDepth:
      return colour_depth(pictures.depth, farthest_);
    case Layer::kClass:
      return colour_ids(pictures.classes);
    case Layer::kInstance:
      return colour_ids(pictures.instances);
  }
  return {};
}

image::Image8 LayerColours::with_legend(const image::Image8& picture, Layer layer) const {
  switch (layer) {
    case Layer::kColour:
      break;
    case Layer::kDepth:
      return with_depth_legend(picture, farthest_);
    case Layer::kClass:
      return with_id_legend(picture, classes_, class_names_);
    case Layer::kInstance:
      return with_id_legend(picture, instances_, {});
  }
  return picture;
}

IdNames load_class_names(const std::filesystem::path& file) {
  const std::string text = read_file(file);
  IdNames names;
  std::size_t line = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view row = std::string_view(text).substr(begin, end - begin);
    begin = end + 1;
    if (++line == 1 || row.empty()) continue;  // the first names the columns
    const std::size_t tab = std::min(row.find('\t'), row.size());
    const std::size_t next = std::min(row.find_first_of("\t\r", tab + 1), row.size());
    const auto id = parse_number<std::uint32_t>(row.substr(0, tab));
    if (!id || next <= tab + 1) {
      refuse(file.string(), fmt::format("line {}", line), "bad-label",
             "not a whole number, a tab and a name, as mpcat40.tsv has them");
    }
    names[*id] = row.substr(tab + 1, next - tab - 1);
  }
  return names;
}

}  // namespace enfilade::draw
