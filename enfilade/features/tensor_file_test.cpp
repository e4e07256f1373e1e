#include "enfilade/features/tensor_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <algorithm>
#include <array>
#include <bit>
#include <csignal>
#include <cstring>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "tests/fuzz/memory_file.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/zip_bytes.h"

namespace enfilade::features {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

const fs::path kSeeds = fs::path(EN_SOURCE_DIR) / "tests/fuzz/seeds/pickle";

template <class T>
std::vector<T> values(const NamedArray* array) {
  if (array == nullptr || array->bytes.size() % sizeof(T) != 0) return {};
  std::vector<T> values(array->bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), array->bytes.data(), array->bytes.size());
  return values;
}

template <class T>
NamedArray array_of(std::string name, DType type, const std::vector<T>& values) {
  return {std::move(name), type, {std::ssize(values)}, std::as_bytes(std::span(values))};
}

std::string safetensors(std::string_view header, std::string_view data) {
  std::string file;
  for (std::size_t i = 0; i < 8; ++i) file += static_cast<char>(header.size() >> 8 * i & 255U);
  return file.append(header).append(data);
}

class TensorFileTest : public ::testing::Test {
 protected:
  fs::path write(std::string_view bytes) {
    write_file_atomically(file_, bytes);
    return file_;
  }
  // What reading these bytes says.
  static std::string refusal_of(const std::string& bytes) {
    const fuzz::MemoryFile file(bytes);
    return tests::refusal<InvalidInput>([&] { TensorFile::open(file.path()); });
  }
  static std::string refusal_of_header(std::string_view header, std::string_view data = "") {
    return refusal_of(safetensors(header, data));
  }

  tests::TemporaryFolder folder_{"tensor_file"};
  fs::path file_ = folder_.path() / "weights";
};

// --- safetensors ---

TEST_F(TensorFileTest, ReadsSafetensorsAsOthersWriteThem) {
  // The example of the format's page, written by hand.
  const TensorFile file = TensorFile::open(write(safetensors(
      R"({"b":{"dtype":"F32","shape":[],"data_offsets":[4,8]},"__metadata__":{"format":"pt"},)"
      R"("a":{"dtype":"U8","shape":[2,2],"data_offsets":[0,4]}, "none":)"
      R"({"shape":[0,3],"dtype":"F64","data_offsets":[8,8]}}   )",
      std::string_view("\x01\x02\x03\x04\x00\x00\x80\x3f", 8))));
  ASSERT_EQ(file.arrays().size(), 3U);
  EXPECT_EQ(file.arrays()[0].name, "a") << "arrays are by name";
  EXPECT_THAT(values<std::uint8_t>(file.find("a")), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(file.find("a")->shape, ElementsAre(2, 2));
  EXPECT_THAT(values<float>(file.find("b")), ElementsAre(1.0F));
  EXPECT_EQ(file.find("b")->elements(), 1U);
  EXPECT_EQ(file.find("none")->elements(), 0U);
  EXPECT_EQ(file.find("c"), nullptr);
  EXPECT_THAT(file.metadata(), ElementsAre(std::pair("format", "pt")));
  EXPECT_EQ(file.path(), file_);
}

TEST_F(TensorFileTest, WhatIsWrittenReadsBackEqual) {
  const std::vector<std::uint16_t> halves{0x3c00, 0xfbff, 1};
  const std::vector<double> doubles{0.1, -2};
  const std::vector<std::int64_t> longs{-1};
  const std::vector<std::uint8_t> bytes{0, 255, 7};
  const std::vector<NamedArray> written{
      array_of("u8", DType::kUint8, bytes),       array_of("f16", DType::kFloat16, halves),
      array_of("bf16", DType::kBFloat16, halves), array_of("f64", DType::kFloat64, doubles),
      array_of("i64", DType::kInt64, longs),      array_of("u64", DType::kUint64, longs),
      array_of("bool", DType::kBool, bytes),      {"a \"quoted\" ü", DType::kInt32, {3, 0}, {}}};
  write_safetensors(file_, written, {{"encoder", "home"}});
  const TensorFile file = TensorFile::open(file_);
  EXPECT_EQ(file.arrays().size(), written.size());
  for (const NamedArray& array : written) {
    const NamedArray* read = file.find(array.name);
    ASSERT_NE(read, nullptr) << array.name;
    EXPECT_EQ(read->type, array.type);
    EXPECT_EQ(read->shape, array.shape);
    EXPECT_TRUE(std::ranges::equal(read->bytes, array.bytes)) << array.name;
  }
  EXPECT_THAT(file.metadata(), ElementsAre(std::pair("encoder", "home")));
  EXPECT_FALSE(fs::exists(file_.string() + ".part"));
}

TEST_F(TensorFileTest, ArraysAreAlignedAsTheFormatAllows) {
  const std::vector<std::uint8_t> odd(3);
  const std::vector<double> doubles(1);
  const std::vector<float> whole(32);
  write_safetensors(file_, std::vector{array_of("odd", DType::kUint8, odd),
                                       array_of("double", DType::kFloat64, doubles),
                                       array_of("whole", DType::kFloat32, whole)});
  const TensorFile file = TensorFile::open(file_);
  const auto place = [&](const char* name) {
    return std::bit_cast<std::uintptr_t>(file.find(name)->bytes.data());
  };
  EXPECT_EQ(place("whole") % 64, 0U) << "pages are mapped at multiples of 4096";
  EXPECT_EQ(place("double"), place("whole") + 128);
  EXPECT_EQ(place("odd"), place("double") + 8) << "the format allows no gaps";
}

TEST_F(TensorFileTest, ArraysAreAlignedWhereTheFileHasThemOtherwise) {
  const TensorFile file =
      TensorFile::open(write(safetensors(R"({"a":{"dtype":"U8","shape":[1],"data_offsets":[0,1]},)"
                                         R"("b":{"dtype":"F32","shape":[1],"data_offsets":[1,5]}})",
                                         std::string_view("\x01\x00\x00\x80\x3f", 5))));
  EXPECT_EQ(std::bit_cast<std::uintptr_t>(file.find("b")->bytes.data()) % alignof(float), 0U);
  EXPECT_THAT(values<float>(file.find("b")), ElementsAre(1.0F));
}

TEST_F(TensorFileTest, HeadersThatAreWrongAreRefused) {
  const std::string entry = R"({"a":{"dtype":"F32","shape":[2],"data_offsets":[0,8]})";
  const std::string data(8, '\0');
  EXPECT_EQ(refusal_of_header(entry + "}", data), "accepted");
  EXPECT_THAT(refusal_of_header("[]"), HasSubstr("does not begin with \"{\""));
  EXPECT_THAT(refusal_of_header("{\"a\""), HasSubstr("not-json"));
  EXPECT_THAT(refusal_of_header(entry + R"(,"a":{"dtype":"F32","shape":[],"data_offsets":[8,12]}})",
                                data + "1234"),
              AllOf(HasSubstr("$.a"), HasSubstr("repeated-name")));
  EXPECT_THAT(refusal_of_header(R"({"__metadata__":{"a":1}})"),
              AllOf(HasSubstr("$.__metadata__.a"), HasSubstr("number 1, not")));
  EXPECT_THAT(refusal_of_header(R"({"a":{"dtype":"F32","shape":[2]}})"), HasSubstr("data_offsets"));
  EXPECT_THAT(
      refusal_of_header(R"({"a":{"dtype":"I16","shape":[2],"data_offsets":[0,4]}})", "1234"),
      AllOf(HasSubstr("$.a.dtype"), HasSubstr("I16"), HasSubstr("not F16, BF16")));
  // Beside others that are read it is left out.
  const TensorFile some = TensorFile::open(
      write(safetensors(R"({"a":{"dtype":"F8_E4M3","shape":[2],"data_offsets":[0,2]},)"
                        R"("b":{"dtype":"U8","shape":[1],"data_offsets":[2,3]}})",
                        "123")));
  EXPECT_THAT(values<std::uint8_t>(some.find("b")), ElementsAre('3'));
  EXPECT_EQ(some.find("a"), nullptr);
  EXPECT_THAT(some.left_out().at("a"), HasSubstr("F8_E4M3"));
  EXPECT_THAT(refusal_of_header(R"({"a":{"dtype":"U8","shape":[-1],"data_offsets":[0,0]}})"),
              AllOf(HasSubstr("$.a.shape[0]"), HasSubstr("-1, not 0 or more")));
  EXPECT_THAT(refusal_of_header(R"({"a":{"dtype":"U8","shape":[1.5],"data_offsets":[0,0]}})"),
              HasSubstr("$.a.shape[0]"));
}

TEST_F(TensorFileTest, OffsetsThatAreWrongAreRefused) {
  const auto one = [](std::string_view shape, std::string_view offsets) {
    return fmt::format(R"({{"a":{{"dtype":"F32","shape":{},"data_offsets":{}}}}})", shape, offsets);
  };
  const std::string data(8, '\0');
  EXPECT_THAT(refusal_of_header(one("[3]", "[0,8]"), data),
              HasSubstr("8 bytes, not the 12 of 3 numbers of type F32"));
  EXPECT_THAT(refusal_of_header(one("[2,4294967296,4294967296]", "[0,8]"), data),
              HasSubstr("8 bytes, not the too many"));
  EXPECT_THAT(refusal_of_header(one("[2]", "[8,0]"), data), HasSubstr("bad-offsets"));
  EXPECT_THAT(refusal_of_header(one("[2]", "[0]"), data), HasSubstr("bad-offsets"));
  EXPECT_THAT(refusal_of_header(one("[2]", "[-8,0]"), data), HasSubstr("-8, not 0 or more"));
  EXPECT_THAT(refusal_of_header(one("[2]", "[0,8]"), "1234"),
              AllOf(HasSubstr("$.a.data_offsets"), HasSubstr("truncated")));
  EXPECT_THAT(refusal_of_header(one("[2]", "[4,12]"), data + data), HasSubstr("hole"));
  EXPECT_THAT(refusal_of_header(one("[2]", "[0,8]"), data + "1"), HasSubstr("surplus"));
  EXPECT_THAT(refusal_of_header("{}", "1"), HasSubstr("surplus"));
  EXPECT_THAT(refusal_of_header(R"({"a":{"dtype":"U8","shape":[4],"data_offsets":[0,4]},)"
                                R"("b":{"dtype":"U8","shape":[4],"data_offsets":[2,6]}})",
                                "123456"),
              AllOf(HasSubstr("$.b.data_offsets"), HasSubstr("overlap")));
}

TEST_F(TensorFileTest, ALengthBeyondTheFileOrTheFormatIsRefused) {
  EXPECT_THAT(refusal_of(""), HasSubstr("truncated"));
  EXPECT_THAT(refusal_of(std::string("\x09\0\0\0\0\0\0\0{}", 10)), HasSubstr("truncated"));
  EXPECT_THAT(refusal_of("\xff\xff\xff\xff\xff\xff\xff\x7f{}"), HasSubstr("at most 100000000"));
  EXPECT_THAT(refusal_of("#!/bin/sh and more"), HasSubstr("no safetensors file"));
}

TEST_F(TensorFileTest, SafetensorsCutAnywhereAreRefused) {
  const std::vector<float> floats{1, 2};
  write_safetensors(file_, std::vector{array_of("a", DType::kFloat32, floats)});
  const std::string whole = read_file(file_);
  for (std::size_t bytes = 0; bytes < whole.size(); ++bytes) {
    EXPECT_THAT(refusal_of(whole.substr(0, bytes)), StartsWith("error: /proc")) << bytes;
  }
}

TEST_F(TensorFileTest, WhatCannotBeWrittenIsTheCallersMistake) {
  const std::vector<float> floats(2);
  const auto refusal = [&](const std::vector<NamedArray>& arrays) {
    return tests::refusal<ArgumentError>([&] { write_safetensors(file_, arrays); });
  };
  NamedArray array = array_of("a", DType::kFloat32, floats);
  EXPECT_THAT(refusal({array, array}), HasSubstr("array \"a\": comes twice"));
  array.shape = {3};
  EXPECT_THAT(refusal({array}), HasSubstr("8 bytes, not the 12 of its shape"));
  array.shape = {-1};
  EXPECT_THAT(refusal({array}), HasSubstr("below 0"));
  EXPECT_THAT(refusal({array_of("__metadata__", DType::kFloat32, floats)}), HasSubstr("keeps"));
  EXPECT_THAT(refusal({array_of("\xff", DType::kFloat32, floats)}), HasSubstr("no UTF-8"));
  EXPECT_FALSE(fs::exists(file_));
}

TEST_F(TensorFileTest, AFullDiskLeavesTheFileAsItWas) {
  write(safetensors("{}", ""));
  // A limit on the size of files stands in for the end of the disk.
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{4096, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::vector<float> floats(2000);
  EXPECT_THAT(tests::refusal<FileError>([&] {
                write_safetensors(file_, std::vector{array_of("a", DType::kFloat32, floats)});
              }),
              HasSubstr("cannot be written"));
  EXPECT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_TRUE(TensorFile::open(file_).arrays().empty());
  EXPECT_FALSE(fs::exists(file_.string() + ".part"));
}

TEST_F(TensorFileTest, AFileThatIsNotThereIsAFileError) {
  EXPECT_THAT(tests::refusal<FileError>([&] { TensorFile::open(file_); }),
              HasSubstr("No such file"));
  EXPECT_THAT(tests::refusal<FileError>([&] { TensorFile::open(folder_.path()); }),
              HasSubstr("Is a directory"));
  EXPECT_THAT(tests::refusal<FileError>([&] { write_safetensors(file_ / "below", {}); }),
              HasSubstr("No such file"));
}

// --- what torch.save() writes: the files are of tests/fuzz/make_weight_seeds.py ---

class TorchFileTest : public ::testing::TestWithParam<const char*> {};

TEST_P(TorchFileTest, HoldsTheTensorsThatPyTorchPutThere) {
  const TensorFile file = TensorFile::open(kSeeds / GetParam());
  EXPECT_EQ(file.arrays().size(), 12U);
  EXPECT_THAT(values<float>(file.find("f32")), ElementsAre(0, 0.5, 1, 1.5, 2, 2.5));
  EXPECT_THAT(file.find("f32")->shape, ElementsAre(2, 3));
  EXPECT_THAT(values<float>(file.find("transposed")), ElementsAre(0, 1.5, 0.5, 2, 1, 2.5));
  EXPECT_THAT(file.find("transposed")->shape, ElementsAre(3, 2));
  EXPECT_THAT(values<float>(file.find("column")), ElementsAre(0.5, 2));
  EXPECT_THAT(values<std::uint16_t>(file.find("f16")), ElementsAre(0x3e00, 0xc000, 0x7bff));
  EXPECT_THAT(values<std::uint16_t>(file.find("bf16")), ElementsAre(0x3f80, 0xc040));
  EXPECT_THAT(values<double>(file.find("f64")), ElementsAre(0.1));
  EXPECT_THAT(values<std::int32_t>(file.find("i32")), ElementsAre(-1, 2));
  EXPECT_THAT(values<std::int64_t>(file.find("i64")), ElementsAre(7));
  EXPECT_THAT(file.find("i64")->shape, ElementsAre());
  EXPECT_THAT(values<std::uint8_t>(file.find("u8")), ElementsAre(0, 255));
  EXPECT_THAT(values<std::uint8_t>(file.find("truth")), ElementsAre(1, 0, 1));
  EXPECT_THAT(file.find("empty")->shape, ElementsAre(0, 3));
  EXPECT_THAT(values<float>(file.find("parameter")), ElementsAre(1, 2));
  const std::array types{DType::kFloat16, DType::kBFloat16, DType::kFloat64, DType::kInt32,
                         DType::kInt64,   DType::kUint8,    DType::kBool};
  const std::array names{"f16", "bf16", "f64", "i32", "i64", "u8", "truth"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    EXPECT_EQ(file.find(names[i])->type, types[i]) << names[i];
  }
  for (const NamedArray& array : file.arrays()) {
    EXPECT_EQ(array.elements() * size_of(array.type), array.bytes.size()) << array.name;
    EXPECT_EQ(std::bit_cast<std::uintptr_t>(array.bytes.data()) % size_of(array.type), 0U);
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, TorchFileTest,
                         ::testing::Values("zip.pth", "legacy.pth", "legacy_4.pth", "very_old.pth"),
                         [](const auto& parameter) {
                           const std::string_view name = parameter.param;
                           return std::string(name.substr(0, name.find('.')));
                         });

TEST_F(TensorFileTest, FindsTheTensorsOfACheckpoint) {
  for (const char* name : {"checkpoint_4.pth", "nested.pth"}) {
    const TensorFile file = TensorFile::open(kSeeds / name);
    ASSERT_EQ(file.arrays().size(), 1U) << name;
    EXPECT_THAT(values<float>(file.find("f32")), ElementsAre(0, 0.5, 1, 1.5, 2, 2.5));
  }
}

TEST_F(TensorFileTest, FindsTheTensorsOfATorchScriptModule) {
  const TensorFile file = TensorFile::open(kSeeds / "script.pth");
  ASSERT_EQ(file.arrays().size(), 3U);
  const NamedArray* weight = file.find("parts.0.linear.weight");
  ASSERT_NE(weight, nullptr);
  EXPECT_EQ(weight->type, DType::kFloat16);
  EXPECT_THAT(weight->shape, ElementsAre(3, 2));
  // 0, 1.5, 0.5, 2, 1, 2.5: a transposed view of the stored numbers.
  EXPECT_THAT(values<std::uint16_t>(weight),
              ElementsAre(0, 0x3e00, 0x3800, 0x4000, 0x3c00, 0x4100));
  EXPECT_THAT(values<std::uint16_t>(file.find("parts.0.linear.bias")),
              ElementsAre(0x3800, 0x3c00, 0x3e00));
  EXPECT_THAT(values<std::int64_t>(file.find("size")), ElementsAre(224));
}

TEST_F(TensorFileTest, NamesOtherCodeThatAPickleHolds) {
  // {"state_dict": {"f32": ..., "epoch": 1}, "args": argparse.Namespace(lr=0.1)}
  const TensorFile file = TensorFile::open(kSeeds / "foreign.pth");
  ASSERT_EQ(file.arrays().size(), 1U);
  EXPECT_THAT(values<float>(file.find("f32")), ElementsAre(0, 0.5, 1, 1.5, 2, 2.5));
  EXPECT_THAT(file.metadata(), ElementsAre(std::pair("args", "")));
  EXPECT_THAT(tests::refusal<InvalidInput>([] { TensorFile::open(kSeeds / "i16.pth"); }),
              AllOf(HasSubstr("torch.ShortStorage"), HasSubstr("unsupported-type")));
  EXPECT_THAT(refusal_of("\x80\x02"
                         "cos\nsystem\nU\x02lsR."),
              HasSubstr("foreign-pickle"));
}

TEST_F(TensorFileTest, PicklesCutAnywhereAreRefused) {
  for (const char* name : {"legacy.pth", "legacy_4.pth", "zip.pth"}) {
    const std::string whole = read_file(kSeeds / name);
    for (std::size_t bytes = 0; bytes < whole.size(); ++bytes) {
      EXPECT_THAT(refusal_of(whole.substr(0, bytes)), StartsWith("error: /proc"))
          << name << " " << bytes;
    }
  }
}

// One byte wrong at a time: refused, or other numbers, names or shapes; never a crash, and never an
// array whose bytes are not those of its shape.
TEST_F(TensorFileTest, DamagedPicklesAreHarmless) {
  for (const char* name :
       {"legacy.pth", "very_old.pth", "zip.pth", "checkpoint_4.pth", "script.pth"}) {
    const std::string whole = read_file(kSeeds / name);
    for (std::size_t at = 0; at < whole.size(); ++at) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ (at % 2 == 0 ? 0xff : 0x01));
      try {
        const fuzz::MemoryFile memory(damaged);
        const TensorFile file = TensorFile::open(memory.path());
        for (const NamedArray& array : file.arrays()) {
          ASSERT_EQ(array.elements() * size_of(array.type), array.bytes.size()) << at;
        }
      } catch (const Error&) {
      }
    }
  }
}

// A zip archive with this pickle and one storage, "0", of 4 floats.
class PickleTest : public TensorFileTest {
 protected:
  static std::string refusal_of_pickle(const std::string& pickle) {
    return refusal_of(scan::testing::zip_of(
        {{"archive/data.pkl", "\x80\x02" + pickle}, {"archive/data/0", std::string(16, 'x')}}));
  }
  // {"a": a tensor of these parts}.
  static std::string tensor(const std::string& offset, const std::string& shape,
                            const std::string& strides, char elements = 4) {
    return "}U\x01"
           "actorch._utils\n_rebuild_tensor_v2\n((U\x07storagectorch\nFloatStorage\n"
           "U\x01"
           "0U\x03"
           "cpuK" +
           std::string(1, elements) + "tQ" + offset + shape + strides + "\x89NtRs.";
  }
  static std::string number(char value) { return {'K', value}; }
  // A tensor without a dictionary around it, of floats or of other numbers.
  static std::string lone_tensor(const std::string& storage = "FloatStorage") {
    std::string one = tensor(number(0), number(4) + "\x85", number(1) + "\x85").substr(4);
    one.resize(one.size() - 2);
    const std::string floats = "FloatStorage";
    return one.replace(one.find(floats), floats.size(), storage);
  }
  // A key and its value, in a dictionary.
  static std::string item(const std::string& key, const std::string& value) {
    return "U" + std::string(1, static_cast<char>(key.size())) + key + value + "s";
  }
  TensorFile open(const std::string& items) {
    return TensorFile::open(
        write(scan::testing::zip_of({{"archive/data.pkl", "\x80\x02}" + items + "."},
                                     {"archive/data/0", std::string(16, 'x')}})));
  }
  // An object of a class, made of arguments and a state; in Python's words c(*arguments).
  static std::string object(const std::string& module, const std::string& name,
                            const std::string& arguments = ")") {
    return "c" + module + "\n" + name + "\n" + arguments + "R";
  }
};

// As most training programs that fine-tune a network save it: the best accuracy is a tensor too.
TEST_F(PickleTest, ATensorBesideTheStateDictIsNoWeight) {
  for (const char* key : {"state_dict", "model_state_dict", "model", "module"}) {
    const TensorFile file = open(item("epoch", number(3)) + item("best_acc1", lone_tensor()) +
                                 item(key, "}" + item("conv1.weight", lone_tensor())));
    ASSERT_EQ(file.arrays().size(), 1U) << key;
    EXPECT_NE(file.find("conv1.weight"), nullptr) << key;
    EXPECT_THAT(file.metadata(), ElementsAre(std::pair("best_acc1", ""), std::pair("epoch", "3")));
  }
  // A "module" of a network is not a dictionary beside it.
  EXPECT_NE(open(item("module", lone_tensor())).find("module"), nullptr);
}

TEST_F(PickleTest, ObjectsOfOtherCodeAreNotNeeded) {
  const std::string state = item("state_dict", "}" + item("w", lone_tensor()));
  // An object with a state; a dictionary of another class, which is filled; a list likewise; a
  // NumPy scalar, whose arguments are objects themselves; a class alone; a call of an object.
  const std::vector<std::string> values{
      object("argparse", "Namespace") + "}" + item("lr", number(1)) + "b",
      "cyacs.config\nCfgNode\n)\x81" + item("SEED", number(1)) + "(U\x01" + "aK\x01U\x01" + "bNu}b",
      object("authors.code", "Items") + number(1) + "a(NNe",
      object("numpy.core.multiarray", "scalar",
             object("numpy", "dtype",
                    "(U\x02"
                    "f8K\x01K\x01t") +
                 "(K\x03U\x01<NNNtb" +
                 object("_codecs", "encode",
                        "U\x01"
                        "xU\x06latin1\x86") +
                 "\x86"),
      "ctorch.optim\nAdam\n",
      object("functools", "partial", "cauthors\nf\n\x85") + ")R",
      "cauthors\nKeywords\n)}\x92"};
  for (const std::string& value : values) {
    for (const std::string& items : {item("args", value) + state, state + item("args", value)}) {
      const TensorFile file = open(items);
      ASSERT_EQ(file.arrays().size(), 1U) << value;
      EXPECT_NE(file.find("w"), nullptr) << value;
      EXPECT_THAT(file.metadata(), ElementsAre(std::pair("args", "")));
    }
  }
}

TEST_F(PickleTest, ObjectsOfOtherCodeAreNoTensors) {
  const std::string sparse = object("torch._utils", "_rebuild_sparse_tensor",
                                    "c"
                                    "torch\nsparse_coo\n" +
                                        lone_tensor() + "\x85\x86");
  const std::string whole = "cmodels.resnet\nResNet\n)\x81}" + item("conv", lone_tensor()) + "b";
  EXPECT_THAT(refusal_of_pickle("}" + item("state_dict", "}" + item("w", sparse)) + "."),
              AllOf(HasSubstr("\"w\": made by \"torch._utils._rebuild_sparse_tensor\""),
                    HasSubstr("foreign-code")));
  for (const std::string& pickle : {whole + ".", "}" + item("model", whole) + "."}) {
    EXPECT_THAT(refusal_of_pickle(pickle),
                AllOf(HasSubstr("\"models.resnet.ResNet\""), HasSubstr("foreign-code"),
                      HasSubstr("torch.save(model.state_dict(), file)")));
  }
  // Beside other tensors it is left out; who needs it says so.
  const TensorFile file = open(item("w", sparse) + item("x", lone_tensor()));
  EXPECT_EQ(file.arrays().size(), 1U);
  EXPECT_THAT(file.left_out().at("w"), HasSubstr("_rebuild_sparse_tensor"));
}

TEST_F(PickleTest, NumbersOfOtherTypesAreLeftOut) {
  for (const char* storage : {"ShortStorage", "ComplexFloatStorage", "UntypedStorage"}) {
    const TensorFile file = open(item("w", lone_tensor(storage)) + item("x", lone_tensor()));
    EXPECT_EQ(file.arrays().size(), 1U);
    EXPECT_THAT(file.left_out().at("w"), HasSubstr(storage));
  }
}

TEST(BareName, HasNothingOfWrappers) {
  EXPECT_EQ(bare_name("conv1.weight"), "conv1.weight");
  for (const char* name : {"module.conv1.weight", "_orig_mod.conv1.weight", "model.conv1.weight",
                           "module._orig_mod.conv1.weight", "_orig_mod.module.conv1.weight",
                           "model._orig_mod.module.conv1.weight", "module.module.conv1.weight",
                           "conv1._orig_mod.weight", "_fsdp_wrapped_module.conv1.weight"}) {
    EXPECT_EQ(bare_name(name), "conv1.weight") << name;
  }
  EXPECT_EQ(bare_name("vision_model.conv1.weight"), "vision_model.conv1.weight");
  EXPECT_EQ(bare_name("block.module.weight"), "block.module.weight");
  EXPECT_EQ(bare_name("not_orig_mod.weight"), "not_orig_mod.weight");
  EXPECT_EQ(bare_name("module."), "module.");
}

TEST_F(PickleTest, TensorsStayWithinTheirStorages) {
  EXPECT_EQ(refusal_of_pickle(tensor(number(0), number(4) + "\x85", number(1) + "\x85")),
            "accepted");
  EXPECT_EQ(refusal_of_pickle(tensor(number(3), number(1) + "\x85", number(9) + "\x85")),
            "accepted");
  const std::string beyond = "\"a\": reaches beyond the 4 elements of its storage [bad-size]";
  EXPECT_THAT(refusal_of_pickle(tensor(number(0), number(5) + "\x85", number(1) + "\x85")),
              HasSubstr(beyond));
  EXPECT_THAT(refusal_of_pickle(tensor(number(1), number(2) + "\x85", number(3) + "\x85")),
              HasSubstr(beyond));
  EXPECT_THAT(refusal_of_pickle(tensor(number(5), number(0) + "\x85", number(1) + "\x85")),
              HasSubstr(beyond));
  const std::string huge = "\x8a\x08\xff\xff\xff\xff\xff\xff\xff\x7f";
  EXPECT_THAT(refusal_of_pickle(tensor(number(0), huge + "\x85", huge + "\x85")),
              HasSubstr(beyond));
  EXPECT_THAT(refusal_of_pickle(tensor(number(0), number(8) + "\x85", number(0) + "\x85")),
              HasSubstr("expanded"));
  EXPECT_THAT(refusal_of_pickle(tensor(number(0), number(4) + "\x85", number(1) + "\x85", 3)),
              HasSubstr("a storage of 16 bytes, not of 3 elements of 4 bytes"));
}

TEST_F(PickleTest, FindsTheTensorsOfEachOfSeveralNetworks) {
  const std::string one = lone_tensor();
  const auto network = [&](const std::string& key, const std::string& name) {
    return item(key, "}" + item("epoch", number(8)) + item("state_dict", "}" + item(name, one)));
  };
  const fuzz::MemoryFile memory(scan::testing::zip_of(
      {{"archive/data.pkl", "\x80\x02}" + network("encoder", "module.word") +
                                network("net", "module._orig_mod.net.word") +
                                item("step", number(3)) + item("best", one) + "."},
       {"archive/data/0", std::string(16, 'x')}}));
  const TensorFile file = TensorFile::open(memory.path());
  ASSERT_EQ(file.arrays().size(), 2U);
  EXPECT_NE(file.find("encoder.word"), nullptr);
  EXPECT_NE(file.find("net.word"), nullptr) << "the network's name stands there once";
  EXPECT_THAT(file.metadata(),
              ElementsAre(std::pair("encoder.epoch", "8"), std::pair("net.epoch", "8")));
}

TEST_F(PickleTest, TensorsAreWellFormed) {
  const std::string minus = "J\xff\xff\xff\xff";
  EXPECT_THAT(refusal_of_pickle(tensor(minus, number(4) + "\x85", number(1) + "\x85")),
              HasSubstr("a tensor's offset: -1, not 0 or more"));
  EXPECT_THAT(refusal_of_pickle(tensor(number(0), minus + "\x85", number(1) + "\x85")),
              HasSubstr("a tensor's shape: -1"));
  EXPECT_THAT(refusal_of_pickle(tensor(number(0), number(4) + "\x85", ")")),
              HasSubstr("1 dimensions and 0 strides"));
  EXPECT_THAT(refusal_of_pickle(tensor(number(0), "N", ")")),
              HasSubstr("a value of another type where a tensor's shape is expected"));
}

TEST_F(PickleTest, DictionariesWithoutTensorsAreRefused) {
  EXPECT_THAT(refusal_of_pickle("}."), HasSubstr("no-tensors"));
  EXPECT_THAT(refusal_of_pickle("N."), HasSubstr("no-tensors"));
  EXPECT_THAT(refusal_of_pickle("c__torch__.a\nB\n)\x81}b."), HasSubstr("no-tensors"));
  // A module that is in itself.
  EXPECT_THAT(refusal_of_pickle("c__torch__.a\nB\n)\x81q\x01}U\x01"
                                "ah\x01sb."),
              HasSubstr("no-tensors"));
  // A dictionary that is in itself.
  EXPECT_THAT(refusal_of_pickle("}q\x01U\x0astate_dicth\x01s."), HasSubstr("no-tensors"));
}

TEST_F(PickleTest, OpcodesOutOfPlaceAreRefused) {
  EXPECT_THAT(
      refusal_of_pickle("."),
      HasSubstr(
          "byte 2: not a pickle of torch.save(): an opcode takes a value from an empty stack"));
  EXPECT_THAT(refusal_of_pickle("(."), HasSubstr("empty stack"));
  EXPECT_THAT(refusal_of_pickle("N(\x85."), HasSubstr("empty stack")) << "behind the mark";
  EXPECT_THAT(refusal_of_pickle("t."), HasSubstr("a mark that was not set"));
  EXPECT_THAT(refusal_of_pickle("h\x07."), HasSubstr("recalls value 7"));
  EXPECT_THAT(refusal_of_pickle("}(Nu."), HasSubstr("key has no value"));
  EXPECT_THAT(refusal_of_pickle("NNa."), HasSubstr("where a list is expected"));
  EXPECT_THAT(refusal_of_pickle("I1\n."), HasSubstr("opcode 0x49"));
  EXPECT_THAT(refusal_of_pickle("X\xff\xff\xff\xff"), HasSubstr("truncated"));
  EXPECT_THAT(refusal_of_pickle("\x80\x09N."), HasSubstr("protocol 9"));
  EXPECT_THAT(refusal_of_pickle("ctorch\nFloatStorage\n)R."),
              HasSubstr("a storage's type is called"));
  EXPECT_THAT(refusal_of_pickle("N)R."), HasSubstr("where a function is expected"));
}

// The first 512 bytes of what tar(1) and Python's tarfile make.
std::string tar_of(const std::string& name) {
  std::string header(1024, '\0');
  header.replace(0, name.size(), name);
  return header.replace(257, 6, "ustar ");
}

TEST_F(TensorFileTest, TheTarFormOf2017IsNamedWithTheLineThatConvertsIt) {
  for (const char* part : {"sys_info", "pickle", "storages", "tensors"}) {
    EXPECT_THAT(refusal_of(tar_of(part)),
                AllOf(HasSubstr("torch.save()'s tar form"), HasSubstr("old-torch"),
                      HasSubstr("torch.save(torch.load(file, weights_only=False), new_file)")));
  }
  EXPECT_THAT(refusal_of(tar_of("resnet/w.pth")),
              AllOf(HasSubstr("begins with \"resnet/w.pth\""), HasSubstr("unpack it")));
}

TEST_F(TensorFileTest, ArchivesOfOtherKindsAreRefused) {
  EXPECT_THAT(refusal_of(scan::testing::zip_of({{"a.txt", "a"}})), HasSubstr("without data.pkl"));
  EXPECT_THAT(
      refusal_of(scan::testing::zip_of({{"a/data.pkl", "\x80\x02}."}, {"a/byteorder", "big"}})),
      HasSubstr("big-endian"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::features
