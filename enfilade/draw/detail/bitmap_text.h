/// \file  A bitmap font, for captions in pictures.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/image/image.h"

namespace enfilade::draw::detail {

using Rgb = std::array<std::uint8_t, 3>;

inline constexpr Rgb kPaper{250, 250, 248};
inline constexpr Rgb kPictureInk{40, 44, 52};

/// Advance of a letter, and height from the top of capitals to the lowest pixel of a "g", in pixels
/// at scale 1.
inline constexpr std::uint32_t kLetterAdvance = 6;
inline constexpr std::uint32_t kLetterHeight = 9;

/// A picture of one colour. 3 channels.
image::Image8 filled(std::uint32_t width, std::uint32_t height, Rgb colour);
/// Fills the part of a rectangle that lies on the picture.
void fill(image::Image8& picture, std::uint32_t x, std::uint32_t y, std::uint32_t width,
          std::uint32_t height, Rgb colour);
/// Copies `from` to (x, y). \pre it fits; both of 3 channels
void paste(image::Image8& picture, const image::Image8& from, std::uint32_t x, std::uint32_t y);

/// Width of a text, pixels.
std::uint32_t text_pixels(std::string_view text, std::uint32_t scale);
/// Draws ASCII text with its top left corner at (x, y), clipped to the picture; other bytes as "?".
/// `scale`: pixels of a dot's edge.
void draw_text(image::Image8& picture, std::uint32_t x, std::uint32_t y, std::string_view text,
               Rgb colour, std::uint32_t scale);
/// The text if it fits `width` pixels, else its beginning and "..".
std::string cut_text(std::string_view text, std::uint32_t width, std::uint32_t scale);

/// Lines of at most `width` pixels, broken at blanks; longer words are cut. Empty text: no line.
std::vector<std::string> wrap_text(std::string_view text, std::uint32_t width, std::uint32_t scale);

}  // namespace enfilade::draw::detail
