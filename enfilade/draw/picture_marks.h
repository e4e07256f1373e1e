/// \file  Signs in pictures that a text can refer to ("set of marks"; Yang et al. 2023).
#pragma once
#include <span>
#include <string>

#include "enfilade/image/image.h"

namespace enfilade::draw {

/// A sign: its middle, in pixels from the left top corner, and one to four letters, ASCII.
struct Mark {
  double x = 0, y = 0;
  std::string text;
};

/// Draws each as light letters on a dark plate with a light rim, in the order of the list. Plates
/// that would cross the edge of the picture are moved inside. One whose middle is outside of the
/// picture is left out.
/// \pre 3 channels
void draw_marks(image::Image8& picture, std::span<const Mark> marks);

}  // namespace enfilade::draw
