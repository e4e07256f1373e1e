#include "enfilade/draw/detail/bitmap_text.h"

#include <algorithm>
#include <cstddef>

#include "enfilade/core/check.h"

namespace enfilade::draw::detail {
namespace {

// From ' ' to '~': rows of five dots, a blank between them; seven rows of capitals, then up to two
// below the line.
constexpr std::array<std::string_view, 95> kGlyphs{
    "..... ..... ..... ..... ..... ..... .....",              // space
    "..#.. ..#.. ..#.. ..#.. ..#.. ..... ..#..",              // !
    ".#.#. .#.#. ..... ..... ..... ..... .....",              // "
    ".#.#. .#.#. ##### .#.#. ##### .#.#. .#.#.",              // #
    "..#.. .#### #.#.. .###. ..#.# ####. ..#..",              // $
    "##..# ##..# ...#. ..#.. .#... #..## #..##",              // %
    ".##.. #..#. #.#.. .#... #.#.# #..#. .##.#",              // &
    "..#.. ..#.. ..... ..... ..... ..... .....",              // '
    "...#. ..#.. .#... .#... .#... ..#.. ...#.",              // (
    ".#... ..#.. ...#. ...#. ...#. ..#.. .#...",              // )
    "..... ..#.. #.#.# .###. #.#.# ..#.. .....",              // *
    "..... ..#.. ..#.. ##### ..#.. ..#.. .....",              // +
    "..... ..... ..... ..... ..... ..#.. ..#.. .#...",        // ,
    "..... ..... ..... .###. ..... ..... .....",              // -
    "..... ..... ..... ..... ..... .##.. .##..",              // .
    "....# ....# ...#. ..#.. .#... #.... #....",              // /
    ".###. #...# #..## #.#.# ##..# #...# .###.",              // 0
    "..#.. .##.. ..#.. ..#.. ..#.. ..#.. .###.",              // 1
    ".###. #...# ....# ..##. .#... #.... #####",              // 2
    ".###. #...# ....# ..##. ....# #...# .###.",              // 3
    "...#. ..##. .#.#. #..#. ##### ...#. ...#.",              // 4
    "##### #.... ####. ....# ....# #...# .###.",              // 5
    "..##. .#... #.... ####. #...# #...# .###.",              // 6
    "##### ....# ...#. ...#. ..#.. ..#.. ..#..",              // 7
    ".###. #...# #...# .###. #...# #...# .###.",              // 8
    ".###. #...# #...# .#### ....# ...#. .##..",              // 9
    "..... .##.. .##.. ..... .##.. .##.. .....",              // :
    "..... .##.. .##.. ..... .##.. .##.. .#...",              // ;
    "...#. ..#.. .#... #.... .#... ..#.. ...#.",              // <
    "..... ..... ##### ..... ##### ..... .....",              // =
    ".#... ..#.. ...#. ....# ...#. ..#.. .#...",              // >
    ".###. #...# ....# ..##. ..#.. ..... ..#..",              // ?
    ".###. #...# #.### #.#.# #.### #.... .####",              // @
    ".###. #...# #...# ##### #...# #...# #...#",              // A
    "####. #...# #...# ####. #...# #...# ####.",              // B
    ".###. #...# #.... #.... #.... #...# .###.",              // C
    "####. #...# #...# #...# #...# #...# ####.",              // D
    "##### #.... #.... ####. #.... #.... #####",              // E
    "##### #.... #.... ####. #.... #.... #....",              // F
    ".###. #...# #.... #..## #...# #...# .####",              // G
    "#...# #...# #...# ##### #...# #...# #...#",              // H
    ".###. ..#.. ..#.. ..#.. ..#.. ..#.. .###.",              // I
    "..### ...#. ...#. ...#. ...#. #..#. .##..",              // J
    "#...# #..#. #.#.. ##... #.#.. #..#. #...#",              // K
    "#.... #.... #.... #.... #.... #.... #####",              // L
    "#...# ##.## #.#.# #.#.# #...# #...# #...#",              // M
    "#...# ##..# ##..# #.#.# #..## #..## #...#",              // N
    ".###. #...# #...# #...# #...# #...# .###.",              // O
    "####. #...# #...# ####. #.... #.... #....",              // P
    ".###. #...# #...# #...# #.#.# #..#. .##.#",              // Q
    "####. #...# #...# ####. #.#.. #..#. #...#",              // R
    ".#### #.... #.... .###. ....# ....# ####.",              // S
    "##### ..#.. ..#.. ..#.. ..#.. ..#.. ..#..",              // T
    "#...# #...# #...# #...# #...# #...# .###.",              // U
    "#...# #...# #...# #...# .#.#. .#.#. ..#..",              // V
    "#...# #...# #...# #.#.# #.#.# ##.## #...#",              // W
    "#...# #...# .#.#. ..#.. .#.#. #...# #...#",              // X
    "#...# #...# .#.#. ..#.. ..#.. ..#.. ..#..",              // Y
    "##### ....# ...#. ..#.. .#... #.... #####",              // Z
    ".###. .#... .#... .#... .#... .#... .###.",              // [
    "#.... #.... .#... ..#.. ...#. ....# ....#",              // backslash
    ".###. ...#. ...#. ...#. ...#. ...#. .###.",              // ]
    "..#.. .#.#. #...# ..... ..... ..... .....",              // ^
    "..... ..... ..... ..... ..... ..... ..... #####",        // _
    ".#... ..#.. ..... ..... ..... ..... .....",              // `
    "..... ..... .###. ....# .#### #...# .####",              // a
    "#.... #.... ####. #...# #...# #...# ####.",              // b
    "..... ..... .###. #.... #.... #...# .###.",              // c
    "....# ....# .#### #...# #...# #...# .####",              // d
    "..... ..... .###. #...# ##### #.... .###.",              // e
    "..##. .#... ####. .#... .#... .#... .#...",              // f
    "..... ..... .#### #...# #...# #...# .#### ....# .###.",  // g
    "#.... #.... ####. #...# #...# #...# #...#",              // h
    "..#.. ..... .##.. ..#.. ..#.. ..#.. .###.",              // i
    "...#. ..... ..##. ...#. ...#. ...#. ...#. #..#. .##..",  // j
    "#.... #.... #..#. #.#.. ##... #.#.. #..#.",              // k
    ".##.. ..#.. ..#.. ..#.. ..#.. ..#.. .###.",              // l
    "..... ..... ##.#. #.#.# #.#.# #.#.# #.#.#",              // m
    "..... ..... ####. #...# #...# #...# #...#",              // n
    "..... ..... .###. #...# #...# #...# .###.",              // o
    "..... ..... ####. #...# #...# #...# ####. #.... #....",  // p
    "..... ..... .#### #...# #...# #...# .#### ....# ....#",  // q
    "..... ..... #.##. ##..# #.... #.... #....",              // r
    "..... ..... .#### #.... .###. ....# ####.",              // s
    ".#... .#... ####. .#... .#... .#... ..##.",              // t
    "..... ..... #...# #...# #...# #...# .####",              // u
    "..... ..... #...# #...# #...# .#.#. ..#..",              // v
    "..... ..... #...# #.#.# #.#.# #.#.# .#.#.",              // w
    "..... ..... #...# .#.#. ..#.. .#.#. #...#",              // x
    "..... ..... #...# #...# #...# #...# .#### ....# .###.",  // y
    "..... ..... ##### ...#. ..#.. .#... #####",              // z
    "...#. ..#.. ..#.. .#... ..#.. ..#.. ...#.",              // {
    "..#.. ..#.. ..#.. ..#.. ..#.. ..#.. ..#..",              // |
    ".#... ..#.. ..#.. ...#. ..#.. ..#.. .#...",              // }
    "..... ..... .#..# #.#.# #..#. ..... .....",              // ~
};

std::string_view glyph(char letter) {
  const bool known = letter >= ' ' && letter <= '~';
  return kGlyphs.at(static_cast<std::size_t>((known ? letter : '?') - ' '));
}

}  // namespace

image::Image8 filled(std::uint32_t width, std::uint32_t height, Rgb colour) {
  image::Image8 picture(width, height, 3);
  fill(picture, 0, 0, width, height, colour);
  return picture;
}

void fill(image::Image8& picture, std::uint32_t x, std::uint32_t y, std::uint32_t width,
          std::uint32_t height, Rgb colour) {
  const std::uint32_t right = std::min(picture.width, x + width);
  const std::uint32_t bottom = std::min(picture.height, y + height);
  for (std::uint32_t row = y; row < bottom; ++row) {
    for (std::uint32_t column = x; column < right; ++column) {
      std::ranges::copy(colour, picture.at(column, row));
    }
  }
}

void paste(image::Image8& picture, const image::Image8& from, std::uint32_t x, std::uint32_t y) {
  EN_CHECK_LE(x + from.width, picture.width);
  EN_CHECK_LE(y + from.height, picture.height);
  for (std::uint32_t row = 0; row < from.height; ++row) {
    std::copy_n(from.at(0, row), std::size_t{from.width} * 3, picture.at(x, y + row));
  }
}

std::uint32_t text_pixels(std::string_view text, std::uint32_t scale) {
  return static_cast<std::uint32_t>(text.size()) * kLetterAdvance * scale;
}

void draw_text(image::Image8& picture, std::uint32_t x, std::uint32_t y, std::string_view text,
               Rgb colour, std::uint32_t scale) {
  for (const char letter : text) {
    const std::string_view dots = glyph(letter);
    for (std::size_t i = 0; i < dots.size(); ++i) {
      if (dots[i] != '#') continue;
      const auto column = static_cast<std::uint32_t>(i % kLetterAdvance);
      const auto row = static_cast<std::uint32_t>(i / kLetterAdvance);
      fill(picture, x + column * scale, y + row * scale, scale, scale, colour);
    }
    x += kLetterAdvance * scale;
  }
}

std::string cut_text(std::string_view text, std::uint32_t width, std::uint32_t scale) {
  if (text_pixels(text, scale) <= width) return std::string(text);
  constexpr std::string_view kCut = "..";
  const std::size_t letters = width / (kLetterAdvance * scale);
  if (letters <= kCut.size()) return std::string(text.substr(0, letters));
  return std::string(text.substr(0, letters - kCut.size())).append(kCut);
}

std::vector<std::string> wrap_text(std::string_view text, std::uint32_t width,
                                   std::uint32_t scale) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of(" \n"), text.size());
    const std::string_view word = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (word.empty()) continue;
    const std::string longer = lines.empty() ? "" : lines.back() + " " + std::string(word);
    if (!lines.empty() && text_pixels(longer, scale) <= width) {
      lines.back() = longer;
    } else {
      lines.push_back(cut_text(word, width, scale));
    }
  }
  return lines;
}

}  // namespace enfilade::draw::detail
