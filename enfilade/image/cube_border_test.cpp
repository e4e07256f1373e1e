#include "enfilade/image/face_cells.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>

#include "tests/support/colour_texel.h"

namespace enfilade::image {
namespace EN_UNIT {

// Colours that say where they are: face, x, y.
CubeMap<std::uint8_t> labelled(std::uint32_t size) {
  CubeMap<std::uint8_t> faces;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    faces[k] = Image8(size, size, 3);
    for (std::size_t y = 0; y < size; ++y) {
      for (std::size_t x = 0; x < size; ++x) {
        std::uint8_t* rgb = faces[k].at(x, y);
        rgb[0] = static_cast<std::uint8_t>(40 * k);
        rgb[1] = static_cast<std::uint8_t>(x);
        rgb[2] = static_cast<std::uint8_t>(y);
      }
    }
  }
  return faces;
}

struct Bordered {
  explicit Bordered(std::uint32_t n) : memory(ColourCells::bytes(n)), size(n) {}
  ColourCells face() { return {memory.data(), size}; }
  std::array<std::uint8_t, 3> texel(std::ptrdiff_t x, std::ptrdiff_t y) const {
    return colour_texel(memory.data(), size, x, y);
  }
  std::vector<std::uint8_t> memory;
  std::uint32_t size;
};

// Of the texels of a cube map, the two closest ones across an edge are neighbours: nothing is
// assumed about how faces are turned.
TEST(CubeBorder, HasTheClosestTexelBeyondEachEdge) {
  constexpr std::uint32_t kSize = 7;
  const CubeMap<std::uint8_t> faces = labelled(kSize);
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    Bordered bordered(kSize);
    write_border(bordered.face(), border_of(faces, cube_face(k)));
    const auto closest = [&](std::ptrdiff_t x, std::ptrdiff_t y) {
      const auto middle = [](auto at) { return (static_cast<double>(at) + 0.5) / kSize; };
      const auto unit = [](Vec3d v) {
        const double norm = std::hypot(v.x, v.y, v.z);
        return Vec3d{v.x / norm, v.y / norm, v.z / norm};
      };
      const Vec3d wanted = unit(cube_direction(cube_face(k), middle(x), middle(y)));
      double best = -1;
      std::array<std::uint8_t, 3> colour{};
      for (std::size_t other = 0; other < kCubeFaces; ++other) {
        if (other == k) continue;
        for (std::size_t v = 0; v < kSize; ++v) {
          for (std::size_t u = 0; u < kSize; ++u) {
            const Vec3d d = unit(cube_direction(cube_face(other), middle(u), middle(v)));
            const double cosine = dot(d, wanted);
            if (cosine > best) {
              best = cosine;
              std::copy_n(faces[other].at(u, v), 3, colour.begin());
            }
          }
        }
      }
      return colour;
    };
    for (std::ptrdiff_t i = 0; i < kSize; ++i) {
      for (const auto& [x, y] : {std::pair{i, std::ptrdiff_t{-1}},
                                 {i, std::ptrdiff_t{kSize}},
                                 {std::ptrdiff_t{-1}, i},
                                 {std::ptrdiff_t{kSize}, i}}) {
        EXPECT_EQ(closest(x, y), bordered.texel(x, y)) << "face " << k << " at " << x << ", " << y;
      }
    }
  }
}

TEST(CubeBorder, HasTheMeanOfThreeTexelsAtACorner) {
  CubeMap<std::uint8_t> faces = labelled(4);
  for (Image8& face : faces) std::ranges::fill(face.pixels, std::uint8_t{0});
  // Corner up-left of the front face, where it meets up and left: 10, 20, 61; mean 30.33.
  *faces[index(CubeFace::kFront)].at(0, 0) = 10;
  *faces[index(CubeFace::kLeft)].at(3, 0) = 20;
  // The up face's texel closest to direction (-1, -1, 1): right is -x, so the last column; down is
  // -z, so the first row.
  *faces[index(CubeFace::kUp)].at(3, 0) = 61;
  for (const auto& [face, x, y] :
       {std::tuple{CubeFace::kFront, -1, -1}, {CubeFace::kLeft, 4, -1}, {CubeFace::kUp, 4, -1}}) {
    Bordered bordered(4);
    write_border(bordered.face(), border_of(faces, face));
    EXPECT_EQ(bordered.texel(x, y)[0], 30) << index(face);
  }
}

TEST(CubeBorder, OfFacesOfOneTexelIsTheirNeighbours) {
  const CubeMap<std::uint8_t> faces = labelled(1);
  Bordered bordered(1);
  write_border(bordered.face(), border_of(faces, CubeFace::kFront));
  EXPECT_EQ(bordered.texel(0, -1)[0], 40 * index(CubeFace::kUp));
  EXPECT_EQ(bordered.texel(0, 1)[0], 40 * index(CubeFace::kDown));
  EXPECT_EQ(bordered.texel(-1, 0)[0], 40 * index(CubeFace::kLeft));
  EXPECT_EQ(bordered.texel(1, 0)[0], 40 * index(CubeFace::kRight));
}

TEST(WriteFaces, WritesThoseThatAreWantedWithTheirBorders) {
  constexpr std::uint32_t kSize = 5;
  const CubeMap<std::uint8_t> faces = labelled(kSize);
  std::vector<Bordered> places(kCubeFaces, Bordered(kSize)), expected = places;
  std::array<ColourCells, kCubeFaces> to;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    to[k] = places[k].face();
    const ColourCells face = expected[k].face();
    if (k != 1 && k != 4) continue;
    write_face(face, faces[k]);
    write_border(face, border_of(faces, cube_face(k)));
  }
  to[0] = {};  // not looked at
  write_faces(faces, 1U << 1 | 1U << 4, to);
  for (std::size_t k = 0; k < kCubeFaces; ++k) EXPECT_EQ(places[k].memory, expected[k].memory) << k;
}

TEST(WriteFace, LeavesTheBorderAlone) {
  const CubeMap<std::uint8_t> faces = labelled(5);
  Bordered bordered(5);
  std::ranges::fill(bordered.memory, std::uint8_t{77});
  write_face(bordered.face(), faces[2]);
  for (std::ptrdiff_t y = -1; y <= 5; ++y) {
    for (std::ptrdiff_t x = -1; x <= 5; ++x) {
      const auto texel = bordered.texel(x, y);
      const bool inside = x >= 0 && y >= 0 && x < 5 && y < 5;
      EXPECT_EQ(texel[1], inside ? x : 77 ^ 0x80);
      EXPECT_EQ(texel[2], inside ? y : 77 ^ 0x80);
    }
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::image
