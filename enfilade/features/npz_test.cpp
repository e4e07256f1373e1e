#include <fmt/format.h>
#include <gmock/gmock.h>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/features/tensor_file.h"
#include "enfilade/scan/file_tree.h"
#include "enfilade/scan/npy.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::features {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using namespace std::string_literals;

// A `.npy` written by hand.
std::string npy(std::string_view type, std::string_view order, std::string_view shape,
                std::string_view data) {
  const std::string header =
      fmt::format("{{'descr': '{}', 'fortran_order': {}, 'shape': {}, }}\n", type, order, shape);
  return "\x93NUMPY\x01"s + '\0' + static_cast<char>(header.size()) + '\0' + header +
         std::string(data);
}

template <class T>
std::vector<T> values(const NamedArray& array) {
  std::vector<T> read(array.bytes.size() / sizeof(T));
  if (!read.empty()) std::memcpy(read.data(), array.bytes.data(), array.bytes.size());
  return read;
}

class NpzTest : public ::testing::Test {
 protected:
  TensorFile open(const std::vector<scan::ZipEntry>& entries) {
    write_file_atomically(file_, scan::zip(entries));
    return TensorFile::open(file_);
  }
  std::string refusal(const std::vector<scan::ZipEntry>& entries) {
    return tests::refusal<InvalidInput>([&] { open(entries); });
  }

  tests::TemporaryFolder folder_{"npz"};
  std::filesystem::path file_ = folder_.path() / "arrays.npz";
};

TEST_F(NpzTest, ArraysAreNamedByTheirPaths) {
  const std::vector<float> one{1, 2, 3, 4, 5, 6}, other{-0.5F};
  const TensorFile file = open({{"one/in.x.npy", scan::write_npy(one, {2, 3})},
                                {"two/in.x.npy", scan::write_npy(other, {1})}});
  ASSERT_EQ(file.arrays().size(), 2U);
  const NamedArray* first = file.find("one/in.x");
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(first->type, DType::kFloat32);
  EXPECT_THAT(first->shape, ElementsAre(2, 3));
  EXPECT_THAT(values<float>(*first), ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(values<float>(*file.find("two/in.x")), ElementsAre(-0.5F));
}

TEST_F(NpzTest, TypesAreThoseOfTheFile) {
  const TensorFile file = open({{"a.npy", npy("<f8", "False", "(1,)", "\0\0\0\0\0\0\xe0?"s)},
                                {"b.npy", npy("<i8", "False", "()", "\x02\0\0\0\0\0\0\0"s)},
                                {"c.npy", npy("|u1", "False", "(3,)", "\x01\x02\xff")},
                                {"d.npy", npy("|b1", "False", "(2,)", "\x01\0"s)},
                                {"e.npy", npy(">i4", "False", "(1,)", "\0\0\1\2"s)},
                                {"f.npy", npy("<f4", "False", "(0, 3)", "")}});
  EXPECT_THAT(values<double>(*file.find("a")), ElementsAre(0.5));
  EXPECT_THAT(values<std::int64_t>(*file.find("b")), ElementsAre(2));
  EXPECT_TRUE(file.find("b")->shape.empty());
  EXPECT_THAT(values<std::uint8_t>(*file.find("c")), ElementsAre(1, 2, 255));
  EXPECT_EQ(file.find("d")->type, DType::kBool);
  EXPECT_THAT(values<std::int32_t>(*file.find("e")), ElementsAre(258)) << "of the other byte order";
  EXPECT_EQ(file.find("f")->elements(), 0U);
}

TEST_F(NpzTest, ColumnsFirstBecomesRowsFirst) {
  const TensorFile file = open({{"a.npy", npy("|u1", "True", "(2, 3)", "\1\4\2\5\3\6")}});
  EXPECT_THAT(values<std::uint8_t>(*file.find("a")), ElementsAre(1, 2, 3, 4, 5, 6));
}

TEST_F(NpzTest, EveryArrayThatIsWrongIsNamed) {
  const std::string said = refusal({{"half/a.npy", npy("<i2", "False", "(1,)", "\1\2")},
                                    {"b.npy", npy("<f4", "False", "(2,)", "1234")},
                                    {"c.npy", npy("|O", "False", "(1,)", "x")},
                                    {"d.npy", "text"}});
  EXPECT_THAT(said, AllOf(HasSubstr("half/a: elements of type \"<i2\"; f2, f4"),
                          HasSubstr("b: 4 bytes of elements, not the 8"), HasSubstr("c: "),
                          HasSubstr("d: no array of NumPy's")));
  EXPECT_THAT(said, HasSubstr("arrays.npz"));
}

TEST_F(NpzTest, AnArrayOfAnotherTypeIsLeftOut) {
  const std::vector<float> one{1};
  const TensorFile file =
      open({{"a.npy", scan::write_npy(one, {1})}, {"b.npy", npy("<i2", "False", "(1,)", "\1\2")}});
  EXPECT_EQ(file.arrays().size(), 1U);
  EXPECT_THAT(file.left_out().at("b"), HasSubstr("<i2"));
  EXPECT_THAT(refusal({{"b.npy", npy("<i2", "False", "(1,)", "\1\2")}}), HasSubstr("<i2"));
}

// 2 x 40 MB of zeros, in 80 kB.
TEST_F(NpzTest, ZerosThatTakeMuchMemoryAreRefused) {
  const std::string zeros = scan::write_npy(std::vector<float>(10'000'000), {10'000'000});
  EXPECT_EQ(open({{"a.npy", zeros}}).arrays().size(), 1U);
  EXPECT_THAT(refusal({{"a.npy", zeros}, {"b.npy", zeros}}),
              HasSubstr("its arrays have more than 67108864 bytes, 100 times"));
}

TEST_F(NpzTest, AZipWithOtherFilesIsNone) {
  const std::vector<float> one{1};
  EXPECT_THAT(refusal({{"a.npy", scan::write_npy(one, {1})}, {"b.txt", "x"}}),
              HasSubstr("data.pkl"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::features
