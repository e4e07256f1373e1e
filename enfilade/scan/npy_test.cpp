#include "enfilade/scan/npy.h"

#include <gmock/gmock.h>
#include <cstddef>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"

namespace enfilade::scan {
namespace EN_UNIT {

using ::testing::ElementsAre;

TEST(Npy, WhatIsWrittenReadsBackEqual) {
  const std::vector<float> numbers{1, -2.5, 3, 4, 5, 6};
  const auto array = NpyArray::parse(write_npy(numbers, {3, 2}));
  EXPECT_EQ(array.kind(), NpyKind::kFloat);
  EXPECT_EQ(array.type(), "<f4");
  EXPECT_THAT(array.shape(), ElementsAre(3, 2));
  EXPECT_EQ(array.number(1), -2.5);
  std::vector<float> copy(numbers.size());
  array.copy_elements(std::as_writable_bytes(std::span(copy)));
  EXPECT_EQ(copy, numbers);
  const std::vector<std::string> texts{"a", "ünï", ""};
  const auto words = NpyArray::parse(write_npy(texts, {3}));
  EXPECT_EQ(words.text(1), "ünï");
  EXPECT_EQ(words.text(2), "");
}

TEST(Npy, WhatIsNoArrayIsRefused) {
  EXPECT_THROW(NpyArray::parse("text"), Error);
  const std::vector<float> numbers{1, 2};
  std::string bytes = write_npy(numbers, {2});
  bytes.pop_back();
  EXPECT_THROW(NpyArray::parse(bytes), Error);
}

}  // namespace EN_UNIT
}  // namespace enfilade::scan
