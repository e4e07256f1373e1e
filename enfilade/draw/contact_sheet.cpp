#include "enfilade/draw/contact_sheet.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/draw/detail/bitmap_text.h"
#include "enfilade/image/codecs.h"

namespace enfilade::draw {
namespace {

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

// Where things are, in pixels.
struct Grid {
  std::size_t columns = 1, rows = 1;
  std::uint32_t width = 0, height = 0;  // of the largest picture
  std::uint32_t caption = 0;            // height below each
  std::uint32_t scale = 1, gap = 6, line = 0;
  std::vector<std::string> title;  // lines
  std::uint32_t title_scale = 1;   // twice that of captions if it fits a line

  std::uint64_t cell_width() const { return std::uint64_t{width} + gap; }
  std::uint64_t cell_height() const { return std::uint64_t{height} + caption + gap; }
  std::uint64_t sheet_width() const { return columns * cell_width() + gap; }
  std::uint64_t title_line() const {
    return std::uint64_t{detail::kLetterHeight + 4} * title_scale;
  }
  std::uint64_t title_height() const {
    return title.empty() ? 0 : title.size() * title_line() + gap;
  }
  std::uint64_t sheet_height() const { return title_height() + gap + rows * cell_height(); }

  void set_title(const std::string& text) {
    const auto inner = static_cast<std::uint32_t>(sheet_width() - 2 * gap);
    title_scale = detail::text_pixels(text, 2 * scale) <= inner ? 2 * scale : scale;
    title = detail::wrap_text(text, inner, title_scale);
  }
};

void check(const SheetPicture& one, std::size_t place) {
  if (one.picture.channels == 3 && !one.picture.pixels.empty()) return;
  throw ArgumentError(fmt::format("pictures[{}]: {} x {} with {} channels; 3 channels are expected",
                                  place, one.picture.width, one.picture.height,
                                  one.picture.channels));
}

Grid lay_out(std::span<const SheetPicture> pictures, const SheetOptions& options) {
  if (pictures.empty()) throw ArgumentError("pictures: none; one at least is expected");
  Grid grid;
  std::size_t lines = 0;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    check(pictures[i], i);
    grid.width = std::max(grid.width, pictures[i].picture.width);
    grid.height = std::max(grid.height, pictures[i].picture.height);
    lines = std::max(lines, lines_of(pictures[i].caption).size());
  }
  grid.scale = std::clamp(grid.width / 320, 1U, 3U);
  grid.line = (detail::kLetterHeight + 2) * grid.scale;
  grid.caption = lines == 0 ? 0 : static_cast<std::uint32_t>(lines) * grid.line + 3 * grid.scale;
  const double n = static_cast<double>(pictures.size());
  const double square = std::sqrt(n * 4 / 3 * static_cast<double>(grid.cell_height()) /
                                  static_cast<double>(grid.cell_width()));
  grid.columns = std::clamp(
      options.columns > 0 ? options.columns : static_cast<std::size_t>(std::lround(square)),
      std::size_t{1}, pictures.size());
  grid.rows = (pictures.size() + grid.columns - 1) / grid.columns;
  grid.set_title(options.title);
  if (std::max(grid.sheet_width(), grid.sheet_height()) > image::kLongestEdge ||
      grid.sheet_width() * grid.sheet_height() > image::kMostPixels) {
    throw ArgumentError(fmt::format(
        "a sheet of {} x {} pixels for {} pictures: at most {} along an edge and {} in all are "
        "allowed; take smaller ones, or another number of columns",
        grid.sheet_width(), grid.sheet_height(), pictures.size(), image::kLongestEdge,
        image::kMostPixels));
  }
  return grid;
}

}  // namespace

image::Image8 contact_sheet(std::span<const SheetPicture> pictures, const SheetOptions& options) {
  const Grid grid = lay_out(pictures, options);
  image::Image8 sheet =
      detail::filled(static_cast<std::uint32_t>(grid.sheet_width()),
                     static_cast<std::uint32_t>(grid.sheet_height()), detail::kPaper);
  for (std::size_t i = 0; i < grid.title.size(); ++i) {
    const auto y = static_cast<std::uint32_t>(grid.gap + i * grid.title_line());
    detail::draw_text(sheet, grid.gap, y, grid.title[i], detail::kPictureInk, grid.title_scale);
  }
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const auto x = static_cast<std::uint32_t>(grid.gap + i % grid.columns * grid.cell_width());
    auto y = static_cast<std::uint32_t>(grid.title_height() + grid.gap +
                                        i / grid.columns * grid.cell_height());
    detail::paste(sheet, pictures[i].picture, x, y);
    y += grid.height + 3 * grid.scale;
    for (const std::string_view line : lines_of(pictures[i].caption)) {
      detail::draw_text(sheet, x, y, detail::cut_text(line, grid.width, grid.scale),
                        detail::kPictureInk, grid.scale);
      y += grid.line;
    }
  }
  return sheet;
}

}  // namespace enfilade::draw
