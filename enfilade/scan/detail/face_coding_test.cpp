#include "enfilade/scan/detail/face_coding.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <functional>
#include <limits>

#include "enfilade/core/rng.h"

namespace enfilade::scan::detail {
namespace EN_UNIT {

template <class T>
std::vector<T> made(std::uint32_t size, const std::function<std::uint64_t(int x, int y)>& value) {
  std::vector<T> texels;
  for (int y = 0; y < static_cast<int>(size); ++y) {
    for (int x = 0; x < static_cast<int>(size); ++x) {
      texels.push_back(static_cast<T>(value(x, y)));
    }
  }
  return texels;
}

// Decoded into memory that held something else.
template <class T>
std::vector<T> decoded(const CodedFace& face, std::uint32_t size) {
  std::vector<T> texels(std::size_t{size} * size, T{0xABCD});
  EXPECT_TRUE(decode_texels(face.coding, face.bytes, size, texels.data()));
  return texels;
}

template <class T>
class FaceCoding : public ::testing::Test {};
using Texels = ::testing::Types<std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(FaceCoding, Texels);

TYPED_TEST(FaceCoding, GivesBackAnyValues) {
  using T = TypeParam;
  constexpr T kMost = std::numeric_limits<T>::max();
  Rng rng(1);
  for (const std::uint32_t size : {1U, 2U, 3U, 17U, 64U}) {
    const std::vector<std::vector<T>> faces{
        made<T>(size, [](int, int) { return 0; }),
        made<T>(size, [](int, int) { return kMost; }),
        made<T>(size, [](int x, int y) { return (x + y) % 2 == 0 ? T{0} : kMost; }),
        made<T>(size, [&](int, int) { return rng.next(); }),
        made<T>(size, [&](int x, int y) { return 9 * x + 5 * y + static_cast<int>(rng.below(4)); }),
    };
    for (const std::vector<T>& face : faces) {
      EXPECT_EQ(decoded<T>(encode_texels<T>(face, size), size), face) << "size " << size;
    }
  }
}

TYPED_TEST(FaceCoding, ChoosesThePredictorThatFits) {
  using T = TypeParam;
  constexpr std::uint32_t kSize = 64;
  Rng rng(2);
  std::vector<std::uint64_t> a(kSize), b(kSize);
  for (auto* list : {&a, &b}) std::ranges::generate(*list, [&] { return rng.next(); });
  const auto at = [](const std::vector<std::uint64_t>& list, int i) {
    return list[static_cast<std::size_t>(i)];
  };
  // Each is near to one prediction only, and rough enough for zstd to find no repetition of its
  // own; two ids in any order are best left alone.
  const auto noise = [&] { return rng.below(2); };
  const std::vector<std::pair<Coding, std::vector<T>>> faces{
      {Coding::kUp, made<T>(kSize, [&](int x, int) { return at(a, x) + noise(); })},
      {Coding::kGradient,
       made<T>(kSize, [&](int x, int y) { return at(a, x) + at(b, y) + noise(); })},
      {Coding::kLeft, made<T>(kSize, [&](int, int y) { return at(b, y) + noise(); })},
      {Coding::kPlain, made<T>(kSize, [&](int, int) { return at(a, noise() == 0 ? 0 : 1); })},
  };
  for (const auto& [coding, texels] : faces) {
    const CodedFace face = encode_texels<T>(texels, kSize);
    EXPECT_EQ(face.coding, coding);
    EXPECT_EQ(decoded<T>(face, kSize), texels);
  }
}

TYPED_TEST(FaceCoding, RefusesBrokenBytes) {
  using T = TypeParam;
  constexpr std::uint32_t kSize = 16;
  const CodedFace face =
      encode_texels<T>(made<T>(kSize, [](int x, int y) { return x * y; }), kSize);
  std::vector<T> texels(2 * kSize * 2 * kSize);
  const image::Bytes bytes = face.bytes;
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_FALSE(decode_texels(face.coding, bytes.first(length), kSize, texels.data()));
  }
  for (const std::uint32_t wrong : {kSize / 2, kSize + 1, 2 * kSize}) {
    EXPECT_FALSE(decode_texels(face.coding, bytes, wrong, texels.data()));
  }
  EXPECT_TRUE(decode_texels(face.coding, bytes, kSize, texels.data()));
}

TEST(FaceCoding, PacksASmoothFaceTightly) {
  constexpr std::uint32_t kSize = 256;
  const auto plane = made<std::uint16_t>(kSize, [](int x, int y) { return 8000 + 3 * x + 7 * y; });
  // A plane has no difference to its gradient: what is left is the first row and zstd's frame.
  EXPECT_LT(encode_texels<std::uint16_t>(plane, kSize).bytes.size(), 200U);
}

}  // namespace EN_UNIT
}  // namespace enfilade::scan::detail
