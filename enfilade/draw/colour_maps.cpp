#include "enfilade/draw/colour_maps.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/numbers.h"
#include "enfilade/core/written_lists.h"
#include "enfilade/draw/detail/bitmap_text.h"
#include "enfilade/scan/panorama_source.h"  // kDepthUnitsPerMetre

namespace enfilade::draw {
namespace {

// Viridis at 1, 14/15, ... 0, as 0xRRGGBB.
constexpr std::array<std::uint32_t, 16> kDepthColours{
    0xfde725, 0xd2e21b, 0xa5db36, 0x7ad151, 0x54c568, 0x35b779, 0x22a884, 0x1f988b,
    0x23888e, 0x2a788e, 0x31688e, 0x39568c, 0x414487, 0x472f7d, 0x481a6c, 0x440154};

// Colours of ids 1, 2, ... as 0xRRGGBB. Wall, floor and ceiling are pale. The others were chosen
// one by one, common categories first: of a grid of moderate chroma, the colour that is farthest in
// CIELAB from those before.
constexpr std::array<std::uint32_t, kChosenColours> kIdColours{
    0xbacbe3, 0xc49a6c, 0xe098fb, 0x08bc47, 0x2cfbe0, 0xf2238f, 0xf2e93e, 0xaa083e, 0x082caa,
    0x1a5008, 0x6b2359, 0xbc1a08, 0xb3fb6b, 0x8f8f08, 0xa111a1, 0xfb9811, 0xf3eacd, 0x7db374,
    0x8f74aa, 0xfb8662, 0x6b2c1a, 0x747dfb, 0x625008, 0xf2e086, 0xe986a1, 0x2c3e62, 0xaa6208,
    0x087dce, 0x08fbaa, 0x08473e, 0x08aab3, 0x473e8f, 0xfb4759, 0x08bcfb, 0x478608, 0xfb62d7,
    0xfbc5fb, 0x087d59, 0x98f2f2, 0xbc59a1, 0x2c7da1};

constexpr Rgb split_rgb(std::uint32_t rgb) {
  return {static_cast<std::uint8_t>(rgb >> 16U), static_cast<std::uint8_t>(rgb >> 8U & 0xffU),
          static_cast<std::uint8_t>(rgb & 0xffU)};
}

std::uint8_t to_level(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

// Smith 1978. Each in [0, 1].
Rgb from_hsv(double hue, double saturation, double value) {
  const auto channel = [&](double turn) {
    const double sector = std::fmod(turn + hue * 6, 6.0);
    const double fall = std::clamp(std::min(sector, 4 - sector), 0.0, 1.0);
    return to_level(255 * value * (1 - saturation * fall));
  };
  return {channel(5), channel(3), channel(1)};
}

template <class T>
void expect_one_channel(const image::Image<T>& picture) {
  if (picture.channels == 1) return;
  throw ArgumentError(fmt::format("picture: {} channels; 1 is allowed", picture.channels));
}

template <class T, class Colour>
image::Image8 coloured(const image::Image<T>& values, const Colour& colour_of) {
  expect_one_channel(values);
  image::Image8 picture(values.width, values.height, 3);
  auto out = picture.pixels.begin();
  for (const T value : values.pixels) out = std::ranges::copy(colour_of(value), out).out;
  return picture;
}

// Neighbours mostly have the same id: its colour is computed once a run.
template <class T>
image::Image8 coloured_ids(const image::Image<T>& ids) {
  std::uint32_t last = 0;
  Rgb colour = kNothing;
  return coloured(ids, [&](T id) {
    if (id != last) colour = id_colour(last = id);
    return colour;
  });
}

template <class T>
std::vector<IdArea> counted(const image::Image<T>& ids) {
  expect_one_channel(ids);
  std::unordered_map<std::uint32_t, std::size_t> pixels;
  for (const T id : ids.pixels) {
    if (id != 0) ++pixels[id];
  }
  std::vector<IdArea> areas;
  for (const auto& [id, count] : pixels) areas.push_back({id, count});
  std::ranges::sort(areas, [](const IdArea& a, const IdArea& b) {
    return a.pixels != b.pixels ? a.pixels > b.pixels : a.id < b.id;
  });
  return areas;
}

// Sizes of a legend below a picture, in pixels.
struct PanelLayout {
  std::uint32_t scale;   // pixels along the edge of a letter's dot
  std::uint32_t margin;  // around everything
  std::uint32_t line;    // from a line of text to the next
  std::uint32_t width;   // of the sheet: a legend needs some, however small the picture

  explicit PanelLayout(const image::Image8& picture)
      : scale(1U + (picture.width >= 480 ? 1 : 0) + (picture.width >= 2000 ? 1 : 0)),
        margin(6 * scale),
        line((detail::kLetterHeight + 4) * scale),
        width(std::max(picture.width, 240U)) {}
};

// The picture with empty paper below.
image::Image8 sheet_of(const image::Image8& picture, const PanelLayout& layout,
                       std::uint32_t below) {
  EN_CHECK_EQ(picture.channels, 3U);
  image::Image8 sheet = detail::filled(layout.width, picture.height + below, detail::kPaper);
  detail::paste(sheet, picture, 0, 0);
  return sheet;
}

// The smallest of 0.1, 0.2, 0.5, 1, ... metres of which at most `most` make the bar: numbers must
// not touch.
double tick_step(double farthest, double most) {
  double step = 0.1;
  for (std::size_t i = 0; farthest / step > most; ++i) step *= i % 3 == 1 ? 2.5 : 2;
  return step;
}

// Numbers below a bar whose left end is at `left` and which is `length` pixels long.
void draw_scale(image::Image8& sheet, const PanelLayout& layout, std::uint32_t left,
                std::uint32_t top, std::uint32_t length, double farthest) {
  const double number_width = 5.0 * detail::kLetterAdvance * layout.scale;
  const double step = tick_step(farthest, length / number_width);
  for (std::size_t i = 0; static_cast<double>(i) * step <= farthest * (1 + 1e-9); ++i) {
    const double metres = static_cast<double>(i) * step;
    const auto x = static_cast<std::uint32_t>(std::lround(metres / farthest * (length - 1)));
    const std::string label = fmt::format("{:.6g}{}", metres, i == 0 ? " m" : "");
    const std::uint32_t half = i == 0 ? 0 : detail::text_pixels(label, layout.scale) / 2;
    detail::fill(sheet, left + x, top, layout.scale, 3 * layout.scale, detail::kPictureInk);
    detail::draw_text(sheet, left + x - std::min(half, x), top + 5 * layout.scale, label,
                      detail::kPictureInk, layout.scale);
  }
}

constexpr std::size_t kMostRows = 12;  // of ids

std::vector<std::string> labels_of(std::span<const IdArea> ids, const IdNames& names) {
  std::vector<std::string> labels;
  for (const IdArea& area : ids) {
    const auto name = names.find(area.id);
    labels.push_back(fmt::format("{}{}", area.id, name == names.end() ? "" : " " + name->second));
  }
  return labels;
}

// The longest of the labels and of the texts that may replace one, and two blanks.
std::string longest(const std::vector<std::string>& labels) {
  std::string found = "nothing known here";
  if (!labels.empty()) found = "+ 99 more";
  for (const std::string& label : labels) {
    if (label.size() > found.size()) found = label;
  }
  return found + "  ";
}

}  // namespace

Rgb depth_colour(double share) {
  const double place = std::clamp(share, 0.0, 1.0) * (kDepthColours.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(place), kDepthColours.size() - 2);
  const double part = place - static_cast<double>(i);
  Rgb colour;
  for (std::size_t c = 0; c < colour.size(); ++c) {
    const auto level = [&](std::uint32_t rgb) { return split_rgb(rgb)[c]; };
    colour[c] = to_level((1 - part) * level(kDepthColours[i]) + part * level(kDepthColours[i + 1]));
  }
  return colour;
}

Rgb id_colour(std::uint32_t id) {
  if (id == 0) return kNothing;
  if (id <= kChosenColours) return split_rgb(kIdColours[id - 1]);
  constexpr double kGolden = 0.61803398874989485;
  // Four kinds of saturation and value, so that ids of like hue (21, 34, 55 apart) differ in them.
  constexpr std::array<std::array<double, 2>, 4> kKinds{
      {{0.75, 0.95}, {0.5, 0.85}, {0.9, 0.6}, {0.55, 1.0}}};
  const double hue = std::fmod(id * kGolden, 1.0);
  const auto [saturation, value] = kKinds[id % kKinds.size()];
  return from_hsv(hue, saturation, value);
}

double farthest_depth(const image::Image16& depth) {
  if (depth.pixels.empty()) return 1;
  return std::max(1.0, std::ceil(std::ranges::max(depth.pixels) / scan::kDepthUnitsPerMetre));
}

DepthRange depth_range(std::span<const image::Image16> depth) {
  constexpr double kLeftOut = 0.05;  // at either end
  constexpr double kLeast = 0.5;     // m
  std::vector<std::size_t> pixels(std::size_t{1} << 16);
  for (const image::Image16& picture : depth) {
    for (const std::uint16_t units : picture.pixels) ++pixels[units];
  }
  pixels[0] = 0;  // no reading
  const auto all = std::accumulate(pixels.begin(), pixels.end(), std::size_t{0});
  if (all == 0) return {};
  // The reading that has this share of all at or below it, in decimetres.
  const auto decimetres = [&](double share) {
    const double wanted = share * static_cast<double>(all);
    std::size_t units = 0, counted = 0;
    while (static_cast<double>(counted) < wanted) counted += pixels[++units];
    return static_cast<double>(units) / scan::kDepthUnitsPerMetre * 10;
  };
  const double nearest = std::floor(decimetres(kLeftOut)) / 10;
  return {nearest, std::max(std::ceil(decimetres(1 - kLeftOut)) / 10, nearest + kLeast)};
}

image::Image8 colour_depth(const image::Image16& depth, const DepthRange& range) {
  const auto& [nearest, farthest] = range;
  if (!std::isfinite(nearest) || !std::isfinite(farthest) || !(nearest < farthest)) {
    throw ArgumentError(
        fmt::format("range: {} to {} metres; nearest < farthest is expected", nearest, farthest));
  }
  std::vector<Rgb> colours(std::size_t{1} << 16);
  for (std::size_t units = 1; units < colours.size(); ++units) {
    const double metres = static_cast<double>(units) / scan::kDepthUnitsPerMetre;
    colours[units] = depth_colour((metres - nearest) / (farthest - nearest));
  }
  colours[0] = kNothing;
  return coloured(depth, [&](std::uint16_t units) { return colours[units]; });
}

image::Image8 colour_depth(const image::Image16& depth, double farthest) {
  if (!(farthest > 0) || !std::isfinite(farthest)) {
    throw ArgumentError(fmt::format("farthest: {} metres; more than 0 is expected", farthest));
  }
  return colour_depth(depth, DepthRange{0, farthest});
}

image::Image8 colour_ids(const image::Image16& ids) { return coloured_ids(ids); }
image::Image8 colour_ids(const image::Image32& ids) { return coloured_ids(ids); }
std::vector<IdArea> count_ids(const image::Image16& ids) { return counted(ids); }
std::vector<IdArea> count_ids(const image::Image32& ids) { return counted(ids); }

image::Image8 with_depth_legend(const image::Image8& picture, double farthest) {
  const PanelLayout layout(picture);
  const std::uint32_t bar = 10 * layout.scale;
  image::Image8 sheet = sheet_of(picture, layout, 2 * layout.margin + bar + layout.line);
  const std::uint32_t top = picture.height + layout.margin;
  constexpr std::string_view kNoReading = "no reading";
  const std::uint32_t words = detail::text_pixels(kNoReading, layout.scale);
  const std::uint32_t length = layout.width - words - 4 * layout.margin;
  for (std::uint32_t x = 0; x < length; ++x) {
    const double share = static_cast<double>(x) / (length - 1);
    detail::fill(sheet, layout.margin + x, top, 1, bar, depth_colour(share));
  }
  draw_scale(sheet, layout, layout.margin, top + bar, length, farthest);
  const std::uint32_t right = layout.width - layout.margin - words;
  detail::fill(sheet, right, top, words, bar, kNothing);
  detail::draw_text(sheet, right, top + bar + 5 * layout.scale, kNoReading, detail::kPictureInk,
                    layout.scale);
  return sheet;
}

image::Image8 with_id_legend(const image::Image8& picture, std::span<const IdArea> ids,
                             const IdNames& names) {
  const PanelLayout layout(picture);
  const std::vector<std::string> labels = labels_of(ids, names);
  const std::uint32_t swatch = 10 * layout.scale;
  const std::uint32_t inner = layout.width - 2 * layout.margin;
  const std::uint32_t item =
      std::min(inner, swatch + layout.margin + detail::text_pixels(longest(labels), layout.scale));
  const std::size_t columns = inner / item, room = columns * kMostRows;
  const std::size_t shown = labels.size() <= room ? labels.size() : room - 1;
  // One more for the words in place of the rest, or of all.
  const std::size_t cells = shown < labels.size() || shown == 0 ? shown + 1 : shown;
  const auto rows = static_cast<std::uint32_t>((cells + columns - 1) / columns);
  image::Image8 sheet = sheet_of(picture, layout, 2 * layout.margin + rows * layout.line);
  for (std::size_t i = 0; i < cells; ++i) {
    const auto x = layout.margin + static_cast<std::uint32_t>(i % columns) * item;
    const auto y =
        picture.height + layout.margin + static_cast<std::uint32_t>(i / columns) * layout.line;
    std::string label = labels.empty() ? std::string("nothing known here")
                                       : fmt::format("+ {} more", labels.size() - shown);
    std::uint32_t indent = 0;
    if (i < shown) {
      detail::fill(sheet, x, y, swatch, swatch, id_colour(ids[i].id));
      label = labels[i];
      indent = swatch + 4 * layout.scale;
    }
    detail::draw_text(sheet, x + indent, y + layout.scale,
                      detail::cut_text(label, item - indent, layout.scale), detail::kPictureInk,
                      layout.scale);
  }
  return sheet;
}

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
  const std::string text = read_plain_text(file);
  IdNames names;
  for (const auto& [line, row] : list_lines(text)) {
    if (line == 1) continue;  // names the columns
    const std::size_t tab = std::min(row.find('\t'), row.size());
    const std::size_t next = std::min(row.find('\t', tab + 1), row.size());
    const auto id = parse_number<std::uint32_t>(trimmed(row.substr(0, tab)));
    if (!id || next <= tab + 1) {
      refuse(file.string(), fmt::format("line {}", line), "bad-label",
             "not a whole number, a tab and a name, as mpcat40.tsv has them");
    }
    names[*id] = row.substr(tab + 1, next - tab - 1);
  }
  return names;
}

}  // namespace enfilade::draw
