#include "enfilade/image/face_cells.h"

#include <algorithm>
#include <cstring>

#include "enfilade/core/check.h"

namespace enfilade::image {
namespace {

constexpr std::uint8_t kFlip = 0x80;

constexpr std::uint64_t kFlips = 0x8080808080808080U;

// Sixteen bytes, which compilers make one register.
void flip16(const std::uint8_t* from, std::uint8_t* to) {
  std::array<std::uint64_t, 2> words;
  std::memcpy(words.data(), from, sizeof(words));
  words[0] ^= kFlips;
  words[1] ^= kFlips;
  std::memcpy(to, words.data(), sizeof(words));
}

// Copies texels and flips their upper bits.
void flip_copy(const std::uint8_t* from, std::size_t bytes, std::uint8_t* to) {
  std::size_t k = 0;
  for (; k + 16 <= bytes; k += 16) flip16(from + k, to + k);
  for (; k < bytes; ++k) to[k] = from[k] ^ kFlip;
}

// A whole row of a cell: the last sixteen bytes overlap those before.
void flip_copy_cell(const std::uint8_t* from, std::uint8_t* to) {
  constexpr std::size_t kLast = (ColourCells::kColumns + 1) * ColourCells::kTexelBytes - 16;
  static_assert(kLast <= 48);
  flip16(from, to);
  flip16(from + 16, to + 16);
  flip16(from + 32, to + 32);
  flip16(from + kLast, to + kLast);
}

// Columns and rows first .. end - 1 of a face, counted from its border's, as RGB or RGBA.
template <std::size_t kChannels>
void write_rows(const std::uint8_t* cells, std::uint32_t size, std::size_t first, std::size_t end,
                std::uint8_t* out) {
  const std::size_t width = end - first;
  for (std::size_t strip = 0; strip < ColourCells::strips(size); ++strip) {
    const std::size_t left = strip * ColourCells::kColumns;
    // The last strip's 19th texel may be the face's last column.
    const std::size_t from = std::max(first, left);
    const std::size_t to = std::min(end, left + ColourCells::kColumns + 1);
    for (std::size_t y = first; y < end; ++y) {
      const std::uint8_t* texel = cells + strip * ColourCells::pitch(size) + y * kCellBytes +
                                  (from - left) * ColourCells::kTexelBytes;
      std::uint8_t* pixel = out + kChannels * ((y - first) * width + from - first);
      for (std::size_t x = from; x < to; ++x, texel += 3, pixel += kChannels) {
        for (std::size_t c = 0; c < 3; ++c) pixel[c] = texel[c] ^ kFlip;
        if constexpr (kChannels == 4) pixel[3] = 255;
      }
    }
  }
}

// The columns of strip k that a value face has.
template <class T>
std::size_t columns_of(std::size_t strip, std::uint32_t size) {
  return std::min<std::size_t>(ValueCells<T>::kColumns, size - strip * ValueCells<T>::kColumns);
}

struct Texel {
  std::size_t face = 0;
  std::ptrdiff_t x = 0, y = 0;
};

// The texel of the neighbouring face at the point (s, t) of a face's edge. The step across the edge
// is so small that it moves the point along the edge by much less than a texel.
Texel across(CubeFace face, double s, double t, std::uint32_t size) {
  constexpr double kStep = 1e-9;
  const auto outwards = [](double u) { return u == 0 ? -kStep : u == 1 ? 1 + kStep : u; };
  const FacePoint point = project_to_cube(cube_direction(face, outwards(s), outwards(t)));
  const auto texel = [size](double u) {
    return std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(u * size), 0, size - 1);
  };
  EN_CHECK(point.face != face);
  return {index(point.face), texel(point.s), texel(point.t)};
}

using Sums = std::array<int, 3>;

void add(const CubeMap<std::uint8_t>& faces, const Texel& texel, Sums& sums) {
  const std::uint8_t* rgb =
      faces[texel.face].at(static_cast<std::size_t>(texel.x), static_cast<std::size_t>(texel.y));
  for (std::size_t c = 0; c < 3; ++c) sums[c] += rgb[c];
}

class BorderWriter {
 public:
  BorderWriter(const CubeMap<std::uint8_t>& faces, CubeFace face)
      : faces_(faces), face_(face), size_(faces[0].width) {
    border_.reserve(3 * border_texels(size_));
  }

  // s, t in {0, 1}
  void corner(double s, double t) {
    const double half = 0.5 / size_;
    const auto inwards = [half](double u) { return u == 0 ? half : 1 - half; };
    const auto last = static_cast<std::ptrdiff_t>(size_) - 1;
    Sums sums{};
    add(faces_, {index(face_), s == 0 ? 0 : last, t == 0 ? 0 : last}, sums);
    add(faces_, across(face_, s, inwards(t), size_), sums);
    add(faces_, across(face_, inwards(s), t, size_), sums);
    for (const int sum : sums) border_.push_back(static_cast<std::uint8_t>((sum + 1) / 3));
  }

  // The texels along the edge from (s, t) to (s1, t1). They lie on a straight line of the
  // neighbour, so its two ends give all of them.
  void edge(double s, double t, double s1, double t1) {
    const double half = 0.5 / size_, ds = (s1 - s) * half, dt = (t1 - t) * half;
    const Texel first = across(face_, s + ds, t + dt, size_);
    const Texel last = across(face_, s1 - ds, t1 - dt, size_);
    EN_CHECK_EQ(first.face, last.face);
    const std::ptrdiff_t steps = std::max<std::ptrdiff_t>(size_ - 1, 1);
    const std::ptrdiff_t dx = (last.x - first.x) / steps, dy = (last.y - first.y) / steps;
    for (std::ptrdiff_t k = 0; k < static_cast<std::ptrdiff_t>(size_); ++k) {
      const std::uint8_t* rgb = faces_[first.face].at(static_cast<std::size_t>(first.x + k * dx),
                                                      static_cast<std::size_t>(first.y + k * dy));
      border_.insert(border_.end(), rgb, rgb + 3);
    }
  }

  std::vector<std::uint8_t> take() { return std::move(border_); }

 private:
  const CubeMap<std::uint8_t>& faces_;
  CubeFace face_;
  std::uint32_t size_;
  std::vector<std::uint8_t> border_;
};

}  // namespace

void ColourCells::write(std::ptrdiff_t x, std::ptrdiff_t y, const std::uint8_t* rgb) const {
  const auto column = static_cast<std::size_t>(x + 1), row = static_cast<std::size_t>(y + 1);
  const std::size_t strip = column / kColumns, place = column % kColumns;
  std::uint8_t* cell = cells + row * kCellBytes;
  if (strip < strips(size)) {
    flip_copy(rgb, kTexelBytes, cell + strip * pitch(size) + place * kTexelBytes);
  }
  if (place == 0 && strip > 0) {
    flip_copy(rgb, kTexelBytes, cell + (strip - 1) * pitch(size) + kColumns * kTexelBytes);
  }
}

void ColourCells::write_row(std::size_t y, const std::uint8_t* rgb) const {
  std::uint8_t* cell = cells + (y + 1) * kCellBytes;
  // The first strip begins with a texel of the border.
  const std::size_t first = std::min<std::size_t>(kColumns, size);
  flip_copy(rgb, first * kTexelBytes, cell + kTexelBytes);
  for (std::size_t strip = 1; strip < strips(size); ++strip) {
    cell += pitch(size);
    const std::size_t begin = strip * kColumns - 1;  // of the face's own texels
    if (begin + kColumns + 1 <= size) {
      flip_copy_cell(rgb + begin * kTexelBytes, cell);
    } else {
      flip_copy(rgb + begin * kTexelBytes, (size - begin) * kTexelBytes, cell);
    }
  }
}

void bordered_rgba(const std::uint8_t* cells, std::uint32_t size, std::span<std::uint8_t> rgba) {
  EN_CHECK_EQ(rgba.size(), 4 * (std::size_t{size} + 2) * (std::size_t{size} + 2));
  write_rows<4>(cells, size, 0, std::size_t{size} + 2, rgba.data());
}

void plain_rgb(const std::uint8_t* cells, std::uint32_t size, std::span<std::uint8_t> rgb) {
  EN_CHECK_EQ(rgb.size(), 3 * std::size_t{size} * size);
  write_rows<3>(cells, size, 1, std::size_t{size} + 1, rgb.data());
}

template <class T>
void ValueCells<T>::from_rows(const T* rows, std::uint32_t size, std::uint8_t* cells) {
  for (std::size_t strip = 0; strip * kColumns < size; ++strip) {
    const std::size_t bytes = columns_of<T>(strip, size) * sizeof(T);
    const T* from = rows + strip * kColumns;
    std::uint8_t* cell = cells + strip * pitch(size);
    for (std::uint32_t y = 0; y < size; ++y, from += size, cell += kCellBytes) {
      std::memcpy(cell, from, bytes);
    }
  }
}

template <class T>
void ValueCells<T>::to_rows(const std::uint8_t* cells, std::uint32_t size, T* rows) {
  for (std::size_t strip = 0; strip * kColumns < size; ++strip) {
    const std::size_t bytes = columns_of<T>(strip, size) * sizeof(T);
    T* to = rows + strip * kColumns;
    const std::uint8_t* cell = cells + strip * pitch(size);
    for (std::uint32_t y = 0; y < size; ++y, to += size, cell += kCellBytes) {
      std::memcpy(to, cell, bytes);
    }
  }
}

template struct ValueCells<std::uint16_t>;
template struct ValueCells<std::uint32_t>;

std::vector<std::uint8_t> border_of(const CubeMap<std::uint8_t>& faces, CubeFace face) {
  for (const Image8& one : faces) {
    EN_CHECK(one.channels == 3 && one.width > 0 && one.width == one.height);
    EN_CHECK_EQ(one.width, faces[0].width);
  }
  BorderWriter writer(faces, face);
  for (const double t : {0.0, 1.0}) {
    writer.corner(0, t);
    writer.edge(0, t, 1, t);
    writer.corner(1, t);
  }
  writer.edge(0, 0, 0, 1);
  writer.edge(1, 0, 1, 1);
  return writer.take();
}

void write_border(const ColourCells& face, std::span<const std::uint8_t> border) {
  write_border_rows(face, border, 0, face.size);
}

void write_border_rows(const ColourCells& face, std::span<const std::uint8_t> border,
                       std::uint32_t begin, std::uint32_t end) {
  EN_CHECK_EQ(border.size(), 3 * border_texels(face.size));
  const std::uint8_t* rgb = border.data();
  const auto size = static_cast<std::ptrdiff_t>(face.size);
  for (const std::ptrdiff_t y : {std::ptrdiff_t{-1}, size}) {
    const bool wanted = y < 0 ? begin == 0 : end == face.size;
    for (std::ptrdiff_t x = -1; x <= size; ++x, rgb += 3) {
      if (wanted) face.write(x, y, rgb);
    }
  }
  for (const std::ptrdiff_t x : {std::ptrdiff_t{-1}, size}) {
    for (std::ptrdiff_t y = 0; y < size; ++y, rgb += 3) {
      if (y >= begin && y < end) face.write(x, y, rgb);
    }
  }
}

void write_face(const ColourCells& face, const std::uint8_t* rgb) {
  for (std::size_t y = 0; y < face.size; ++y) face.write_row(y, rgb + 3 * y * face.size);
}

void write_face(const ColourCells& face, const Image8& picture) {
  EN_CHECK(picture.channels == 3 && picture.width == face.size && picture.height == face.size);
  write_face(face, picture.pixels.data());
}

void write_faces(const CubeMap<std::uint8_t>& faces, std::uint8_t wanted,
                 const std::array<ColourCells, kCubeFaces>& to) {
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    if ((wanted >> k & 1) == 0) continue;
    write_face(to[k], faces[k]);
    write_border(to[k], border_of(faces, cube_face(k)));
  }
}

}  // namespace enfilade::image
