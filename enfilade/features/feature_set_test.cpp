#include "enfilade/features/feature_set.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstring>
#include <limits>
#include <numeric>
#include <thread>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::features {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const fs::path kSeeds = fs::path(EN_SOURCE_DIR) / "tests/fuzz/seeds";
constexpr std::size_t kViews = 36;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

std::vector<FeatureKey> keys_of(std::initializer_list<const char*> viewpoints) {
  std::vector<FeatureKey> keys;
  for (const char* viewpoint : viewpoints) keys.push_back({"home_1", viewpoint});
  return keys;
}

FeatureInfo made_info(DType type = DType::kFloat32, std::size_t dimensions = 3) {
  return {"home", "own", "0123456789abcdef", kViews, dimensions, {320, 240, degrees(45.5)}, type};
}

// Numbers that halves hold exactly, different in each row.
std::vector<float> row_of(std::size_t row, std::size_t dimensions = 3) {
  std::vector<float> numbers(kViews * dimensions);
  std::iota(numbers.begin(), numbers.end(), 100.0F * static_cast<float>(row));
  for (float& number : numbers) number = number / 4 - 5;
  return numbers;
}

void write_set(const fs::path& file, const FeatureInfo& info, const std::vector<FeatureKey>& keys,
               std::size_t first_row = 0) {
  FeatureWriter writer = FeatureWriter::create(file, info, keys);
  for (std::size_t i = keys.size(); i-- > 0;) writer.write(i, row_of(first_row + i));
  writer.finish();
}

std::vector<float> views(const FeatureSet& set, const FeatureKey& key) {
  std::vector<float> out(set.info().views * set.info().dimensions);
  const auto row = set.row(key.scan, key.viewpoint);
  if (row) set.copy_views(*row, out);
  return out;
}

std::string refusal_of(const fs::path& file) {
  return tests::refusal<InvalidInput>([&] {
    const FeatureSet set = FeatureSet::open(file);
    for (const FeatureKey& key : set.keys()) views(set, key);
  });
}

class FeatureSetTest : public ::testing::Test {
 protected:
  fs::path path(const std::string& name) const { return folder_.path() / name; }
  fs::path write(const std::string& name, std::string_view bytes) const {
    write_file_atomically(path(name), bytes);
    return path(name);
  }

  tests::TemporaryFolder folder_{"feature_set"};
};

// --- every format -------------------------------------------------------------------------------

struct Kind {
  const char* file;
  DType type;
};

class FormatTest : public FeatureSetTest, public ::testing::WithParamInterface<Kind> {};

TEST_P(FormatTest, WhatIsWrittenReadsBackEqual) {
  const fs::path file = path(GetParam().file);
  const auto keys = keys_of({"cc", "aa", "bb"});
  const FeatureInfo info = made_info(GetParam().type);
  write_set(file, info, keys);
  const FeatureSet set = FeatureSet::open(file);
  EXPECT_EQ(set.info().views, kViews);
  EXPECT_EQ(set.info().dimensions, 3U);
  EXPECT_EQ(set.info().type, GetParam().type);
  EXPECT_EQ(set.info().camera, info.camera) << "degrees come back to the bit";
  const bool says = format_of(file) != FeatureFormat::kTsv;
  EXPECT_EQ(set.info().encoder, says ? "home" : "");
  EXPECT_EQ(set.info().preprocessing, says ? "own" : "");
  EXPECT_EQ(set.info().weights, says ? "0123456789abcdef" : "");
  EXPECT_THAT(set.keys(), ::testing::UnorderedElementsAreArray(keys));
  for (std::size_t i = 0; i < keys.size(); ++i) EXPECT_EQ(views(set, keys[i]), row_of(i));
  for (std::size_t row = 0; row < keys.size(); ++row) {
    EXPECT_EQ(set.row(set.keys()[row].scan, set.keys()[row].viewpoint), row);
  }
  EXPECT_EQ(set.row("home_1", "dd"), std::nullopt);
  std::vector<float> view(3);
  set.copy_view(*set.row("home_1", "aa"), 35, view);
  EXPECT_THAT(view, ElementsAre(205 / 4.0F - 5, 206 / 4.0F - 5, 207 / 4.0F - 5));
}

TEST_P(FormatTest, TheFileIsThereWhenItIsFinished) {
  const fs::path file = path(GetParam().file), part = path(GetParam().file + std::string(".part"));
  write_file_atomically(file, "old");
  {
    FeatureWriter writer =
        FeatureWriter::create(file, made_info(GetParam().type), keys_of({"aa", "bb"}));
    EXPECT_EQ(writer.rows_left(), 2U);
    writer.write(1, row_of(7));
    writer.write(1, row_of(1));
    EXPECT_EQ(writer.rows_left(), 1U);
    EXPECT_TRUE(writer.written(1));
    EXPECT_FALSE(writer.written(0));
    EXPECT_THAT(tests::refusal<ArgumentError>([&] { writer.finish(); }),
                HasSubstr("1 of 2 viewpoints are not written yet, the first of scan \"home_1\", "
                          "viewpoint \"aa\""));
    EXPECT_EQ(read_file(file), "old");
    EXPECT_TRUE(fs::exists(part));
    if (format_of(file) != FeatureFormat::kTsv) {  // whose rows are there once, and for good
      writer.write(0, row_of(0));
      writer.finish();
      EXPECT_EQ(views(FeatureSet::open(file), {"home_1", "bb"}), row_of(1));
      EXPECT_FALSE(fs::exists(part));
    }
  }
}

TEST_P(FormatTest, FilesCutAnywhereAreRefused) {
  const fs::path file = path(GetParam().file);
  write_set(file, made_info(GetParam().type), keys_of({"aa", "bb"}));
  const std::string whole = read_file(file);
  const std::size_t row = whole.find('\n') + 1, features = whole.rfind('\t', row) + 1;
  const bool is_tsv = format_of(file) == FeatureFormat::kTsv;
  const std::size_t step = format_of(file) == FeatureFormat::kHdf5 ? 97 : 7;
  for (std::size_t bytes = 0; bytes + 1 < whole.size(); bytes += step) {
    // Cut between rows a TSV is a shorter one; cut after one or two dimensions of its first row,
    // one of fewer dimensions.
    constexpr std::size_t kDimension = kViews * 4 / 3 * 4;
    if (is_tsv && (bytes == row || bytes + 1 == row)) continue;
    if (is_tsv && bytes < row && bytes > features && (bytes - features) % kDimension == 0) continue;
    write_file_atomically(file, whole.substr(0, bytes));
    EXPECT_THAT(refusal_of(file), HasSubstr(file.string())) << bytes;
  }
}

TEST_P(FormatTest, NumbersThatAreNoneAreNotWritten) {
  FeatureWriter writer =
      FeatureWriter::create(path(GetParam().file), made_info(GetParam().type), keys_of({"aa"}));
  std::vector<float> numbers = row_of(0);
  numbers[5] = -kInfinity;
  const auto refusal = [&] {
    return tests::refusal<ArgumentError>([&] { writer.write(0, numbers); });
  };
  EXPECT_THAT(refusal(), AllOf(HasSubstr("viewpoint \"aa\": number 5 is -inf"),
                               HasSubstr(path(GetParam().file).string())));
  numbers[5] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(refusal(), HasSubstr("number 5 is nan"));
  numbers[5] = 65520;
  EXPECT_EQ(refusal() == "accepted", GetParam().type == DType::kFloat32);
  numbers.pop_back();
  EXPECT_THAT(refusal(), HasSubstr("107 numbers, not 36 x 3"));
}

TEST_P(FormatTest, AFullDiskIsAnError) {
  // A limit on the size of files stands in for the end of the disk.
  const fs::path file = path(GetParam().file);
  const FeatureInfo info = made_info(GetParam().type, 2048);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{65536, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string refusal = tests::refusal<FileError>([&] {
    FeatureWriter writer = FeatureWriter::create(file, info, keys_of({"aa", "bb"}));
    writer.write(0, std::vector<float>(kViews * 2048));
    writer.write(1, std::vector<float>(kViews * 2048));
    writer.finish();
  });
  EXPECT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_THAT(refusal, AllOf(HasSubstr(file.string()), HasSubstr("cannot be written"),
                             HasSubstr("too large")));
  EXPECT_FALSE(fs::exists(file));
}

TEST_P(FormatTest, OneWriterAtATime) {
  const fs::path file = path(GetParam().file);
  const FeatureInfo info = made_info(GetParam().type);
  const FeatureWriter writer = FeatureWriter::create(file, info, keys_of({"aa"}));
  EXPECT_THAT(
      tests::refusal<FileError>([&] { FeatureWriter::create(file, info, keys_of({"aa"})); }),
      HasSubstr("another process is writing it just now"));
}

INSTANTIATE_TEST_SUITE_P(Formats, FormatTest,
                         ::testing::Values(Kind{"f32.safetensors", DType::kFloat32},
                                           Kind{"f16.safetensors", DType::kFloat16},
                                           Kind{"f32.tsv", DType::kFloat32},
                                           Kind{"f32.hdf5", DType::kFloat32},
                                           Kind{"f16.h5", DType::kFloat16}),
                         [](const auto& parameter) {
                           std::string name = parameter.param.file;
                           std::ranges::replace(name, '.', '_');
                           return name;
                         });

TEST_F(FeatureSetTest, ScoresOfClassesBehindTheFeaturesAreLeftOut) {
  constexpr std::size_t kAll = 1003;
  const FeatureInfo info = made_info(DType::kFloat32, kAll);
  FeatureWriter writer = FeatureWriter::create(path("f.safetensors"), info, keys_of({"a"}));
  const std::vector<float> numbers = row_of(0, kAll);
  writer.write(0, numbers);
  writer.finish();
  const FeatureSet all = FeatureSet::open(path("f.safetensors"));
  EXPECT_EQ(without_class_scores(all, 768).info().dimensions, kAll) << "other columns: as it is";
  const FeatureSet set = without_class_scores(all, 3);
  EXPECT_EQ(set.info().dimensions, 3U);
  const std::vector<float> read = views(set, {"home_1", "a"});
  ASSERT_EQ(read.size(), kViews * 3);
  for (std::size_t view = 0; view < kViews; ++view) {
    EXPECT_EQ(read[view * 3 + 2], numbers[view * kAll + 2]) << view;
  }
  std::vector<float> one(3);
  set.copy_view(0, 35, one);
  EXPECT_EQ(one[1], numbers[35 * kAll + 1]);
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { set.first_columns(4); }),
              HasSubstr("columns: 4, not from 1 to the 3 that there are"));
}

TEST_F(FeatureSetTest, TheSuffixNamesTheFormat) {
  EXPECT_EQ(format_of("a/b.safetensors"), FeatureFormat::kSafetensors);
  EXPECT_EQ(format_of("b.tsv"), FeatureFormat::kTsv);
  EXPECT_EQ(format_of("b.hdf5"), FeatureFormat::kHdf5);
  EXPECT_EQ(format_of("b.h5"), FeatureFormat::kHdf5);
  EXPECT_THAT(tests::refusal<ArgumentError>([] { format_of("b.npz"); }), HasSubstr("b.npz: ends"));
}

// As cameras name their pictures: IMG_1_01.jpg.
TEST_F(FeatureSetTest, ViewpointsWithBarsAreFoundByTheWholeName) {
  const std::vector<FeatureKey> keys{{"home", "IMG_1_01"}, {"my_home", "IMG_1_02"}};
  for (const char* name : {"f.safetensors", "f.hdf5", "f.tsv"}) {
    write_set(path(name), made_info(), keys);
    const FeatureSet set = FeatureSet::open(path(name));
    for (std::size_t k : {0U, 1U}) EXPECT_EQ(views(set, keys[k]), row_of(k)) << name;
    EXPECT_FALSE(set.row("home", "IMG_1_02")) << name;
  }
}

TEST_F(FeatureSetTest, WhatCannotBeWrittenIsTheCallersMistake) {
  const auto refusal = [&](const FeatureInfo& info, std::vector<FeatureKey> keys,
                           const char* name = "f.safetensors") {
    return tests::refusal<ArgumentError>(
        [&] { FeatureWriter::create(path(name), info, std::move(keys)); });
  };
  FeatureInfo info = made_info();
  EXPECT_THAT(refusal(info, {}), HasSubstr("of no viewpoint"));
  EXPECT_THAT(refusal(info, keys_of({"aa", "aa"})), HasSubstr("viewpoint \"aa\" comes twice"));
  EXPECT_THAT(refusal(info, {{"s", "a_b"}, {"s_a", "b"}}), HasSubstr("comes twice"));
  EXPECT_THAT(refusal(info, {{"s/t", "a"}}), HasSubstr("\"s/t\" is not an id"));
  EXPECT_THAT(refusal(info, {{"s", "a\tb"}}), HasSubstr("viewpoint \"a\\tb\": \"a\\tb\" is not"));
  EXPECT_THAT(refusal(info, {{"", "a"}}), HasSubstr("scan \"\""));
  info.dimensions = 0;
  EXPECT_THAT(refusal(info, keys_of({"aa"})), HasSubstr("36 views of 0 dimensions"));
  info = made_info(DType::kFloat64);
  EXPECT_THAT(refusal(info, keys_of({"aa"})), HasSubstr("F64, not F32 or F16"));
  info = made_info(DType::kFloat16);
  EXPECT_THAT(refusal(info, keys_of({"aa"}), "f.tsv"), HasSubstr("TSV holds 36 of type F32"));
  info = made_info();
  info.views = 12;
  EXPECT_THAT(refusal(info, keys_of({"aa"}), "f.tsv"), HasSubstr("12 views"));
  info.camera.width = 0;
  EXPECT_NE(refusal(info, keys_of({"aa"})), "accepted");
  EXPECT_TRUE(fs::is_empty(folder_.path()));
}

// --- going on after a stop ----------------------------------------------------------------------

TEST_F(FeatureSetTest, GoesOnWhereAStoppedRunWas) {
  const fs::path file = path("f.safetensors");
  const auto keys = keys_of({"aa", "bb", "cc"});
  FeatureWriter::create(file, made_info(), keys).write(1, row_of(1));
  {
    FeatureWriter writer = FeatureWriter::create(file, made_info(), keys);
    EXPECT_TRUE(writer.written(1));
    EXPECT_EQ(writer.rows_left(), 2U);
    writer.write(0, row_of(0));
    writer.write(2, row_of(2));
    writer.finish();
  }
  const FeatureSet set = FeatureSet::open(file);
  for (std::size_t i = 0; i < keys.size(); ++i) EXPECT_EQ(views(set, keys[i]), row_of(i));
}

TEST_F(FeatureSetTest, BeginsAnewForOtherFeatures) {
  const fs::path file = path("f.safetensors");
  const auto keys = keys_of({"aa", "bb"});
  const auto left_after = [&](const FeatureInfo& info, const std::vector<FeatureKey>& others) {
    FeatureWriter::create(file, made_info(), keys).write(1, row_of(1));
    return FeatureWriter::create(file, info, others).rows_left();
  };
  EXPECT_EQ(left_after(made_info(), keys), 1U);
  EXPECT_EQ(left_after(made_info(), keys_of({"aa", "cc"})), 2U);
  EXPECT_EQ(left_after(made_info(DType::kFloat16), keys), 2U);
  FeatureInfo info = made_info();
  info.weights = "fedcba9876543210";
  EXPECT_EQ(left_after(info, keys), 2U);
}

TEST_F(FeatureSetTest, ARowThatIsTornOrLostIsNotWritten) {
  const fs::path file = path("f.safetensors"), part = path("f.safetensors.part");
  const auto keys = keys_of({"aa", "bb"});
  {
    FeatureWriter writer = FeatureWriter::create(file, made_info(), keys);
    writer.write(0, row_of(0));
    writer.write(1, row_of(1));
  }
  const std::string whole = read_file(part);
  const std::size_t row_bytes = row_of(0).size() * sizeof(float), journal = 16;
  const std::size_t data = whole.size() - journal - 2 * row_bytes;
  for (std::size_t at = data; at < whole.size(); at += 61) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    write_file_atomically(part, damaged);
    const FeatureWriter writer = FeatureWriter::create(file, made_info(), keys);
    const bool first = at < data + row_bytes || (at >= whole.size() - 16 && at < whole.size() - 8);
    EXPECT_EQ(writer.written(0), !first) << at;
    EXPECT_EQ(writer.written(1), first) << at;
  }
}

TEST_F(FeatureSetTest, ARunKilledJustBeforeItRenamesIsWhole) {
  const fs::path file = path("f.safetensors"), part = path("f.safetensors.part");
  const auto keys = keys_of({"aa", "bb"});
  write_set(file, made_info(), keys);
  fs::rename(file, part);
  for (int run = 0; run < 2; ++run) {  // the second finds the first's part
    FeatureWriter writer = FeatureWriter::create(file, made_info(), keys);
    EXPECT_EQ(writer.rows_left(), 0U);
    if (run == 1) writer.finish();
  }
  EXPECT_EQ(views(FeatureSet::open(file), keys[1]), row_of(1));
}

TEST_F(FeatureSetTest, SurvivesBeingKilledAtAnyMoment) {
  const fs::path file = path("f.safetensors");
  std::vector<FeatureKey> keys;
  for (int i = 0; i < 400; ++i) keys.push_back({"home_1", fmt::format("{:04}", i)});
  const FeatureInfo info = made_info(DType::kFloat32, 64);
  std::size_t kept = 0, runs = 0;
  while (!fs::exists(file) && ++runs < 200) {
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      FeatureWriter writer = FeatureWriter::create(file, info, keys);
      for (std::size_t i = 0; i < keys.size(); ++i) {
        if (!writer.written(i)) writer.write(i, row_of(i, 64));
      }
      writer.finish();
      _exit(0);
    }
    // 0.3 ms to 5 s: an emulated or busy machine has to come to the end too.
    usleep(static_cast<useconds_t>(300 * std::pow(1.05, runs)));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    if (fs::exists(file)) break;
    const std::size_t left = FeatureWriter::create(file, info, keys).rows_left();
    EXPECT_GE(keys.size() - left, kept) << "what was written stays";
    kept = keys.size() - left;
  }
  ASSERT_TRUE(fs::exists(file)) << runs;
  const FeatureSet set = FeatureSet::open(file);
  for (std::size_t i = 0; i < keys.size(); ++i)
    EXPECT_TRUE(views(set, keys[i]) == row_of(i, 64)) << i;
}

// --- files of others ----------------------------------------------------------------------------

TEST_F(FeatureSetTest, ReadsSafetensorsWithoutMetadata) {
  const std::vector<float> numbers{1, 2, 3, 4};
  const auto array = [&](const char* name, std::vector<std::int64_t> shape) {
    return NamedArray{name, DType::kFloat32, std::move(shape), std::as_bytes(std::span(numbers))};
  };
  write_safetensors(path("f.safetensors"), std::vector{array("s_a", {2, 2})});
  const FeatureSet set = FeatureSet::open(path("f.safetensors"));
  EXPECT_EQ(set.info().views, 2U);
  EXPECT_EQ(set.info().camera, Camera{});
  EXPECT_EQ(set.info().encoder, "");
  EXPECT_EQ(views(set, {"s", "a"}), numbers);

  const auto refusal = [&](const std::vector<NamedArray>& arrays,
                           const std::map<std::string, std::string>& metadata = {}) {
    write_safetensors(path("f.safetensors"), arrays, metadata);
    return refusal_of(path("f.safetensors"));
  };
  EXPECT_THAT(refusal({}), HasSubstr("no-features"));
  EXPECT_THAT(refusal({array("s_a", {4})}),
              HasSubstr("\"s_a\": not an array of shape (views, dimensions)"));
  EXPECT_THAT(refusal({array("conv1.weight", {2, 2})}), HasSubstr("not <scan>_<viewpoint>"));
  EXPECT_THAT(refusal({array("s_a", {2, 2}), array("s_b", {4, 1})}),
              HasSubstr("\"s_b\": 4 x 1 of F32, not 2 x 2 of F32 as the first"));
  EXPECT_THAT(refusal({{"s_a", DType::kInt32, {2, 2}, array("s_a", {2, 2}).bytes}}),
              HasSubstr("I32, not F32 or F16"));
  EXPECT_THAT(refusal({array("s_a", {2, 2})}, {{"vfov", "sixty"}}),
              HasSubstr("vfov: \"sixty\", not a number"));
  EXPECT_THAT(refusal({array("s_a", {2, 2})}, {{"image_w", "0"}}), HasSubstr("bad-camera"));
  EXPECT_THAT(refusal({array("s_a", {2, 2})}, {{"vfov", "180"}}), HasSubstr("bad-camera"));
}

TEST_F(FeatureSetTest, NumbersThatAreNoneAreFoundWhenTheyAreRead) {
  const std::vector<float> numbers{1, kInfinity};
  const std::vector<std::uint16_t> halves{0x3c00, 0xfc01};
  for (const auto& [type, bytes] : {std::pair(DType::kFloat32, std::as_bytes(std::span(numbers))),
                                    std::pair(DType::kFloat16, std::as_bytes(std::span(halves)))}) {
    write_safetensors(path("f.safetensors"), std::vector{NamedArray{"s_a", type, {2, 1}, bytes}});
    const FeatureSet set = FeatureSet::open(path("f.safetensors"));
    std::vector<float> view(1);
    set.copy_view(0, 0, view);
    EXPECT_EQ(view[0], 1);
    EXPECT_THAT(tests::refusal<InvalidInput>([&] { set.copy_view(0, 1, view); }),
                AllOf(HasSubstr("viewpoint \"a\""), HasSubstr("not-finite")));
  }
}

// base64 of 36 floats, 1.0 = 00 00 80 3f in each: "AACAPw" is that in six characters and a bit, so
// three floats are 16 characters.
std::string ones() {
  std::string text;
  for (std::size_t i = 0; i < kViews / 3; ++i) text += "AACAPwAAgD8AAIA/";
  return text;
}

std::string tsv_row(const std::string& viewpoint, const std::string& features,
                    const std::string& camera = "640\t480\t60") {
  return "17DRP5sb8fy\t" + viewpoint + "\t" + camera + "\t" + features + "\r\n";
}

TEST_F(FeatureSetTest, ReadsTsvAsPythonWritesIt) {
  const FeatureSet set =
      FeatureSet::open(write("f.tsv", tsv_row("aa", ones()) + tsv_row("bb", ones()) + "\n"));
  EXPECT_EQ(set.info().dimensions, 1U);
  EXPECT_EQ(set.info().camera, Camera{});
  ASSERT_EQ(set.keys().size(), 2U);
  EXPECT_EQ(set.keys()[0], (FeatureKey{"17DRP5sb8fy", "aa"})) << "rows in the order of the file";
  EXPECT_EQ(views(set, set.keys()[1]), std::vector<float>(kViews, 1.0F));
}

TEST_F(FeatureSetTest, TsvThatIsWrongIsRefused) {
  const auto refusal = [&](const std::string& text) { return refusal_of(write("f.tsv", text)); };
  const std::string good = tsv_row("aa", ones());
  EXPECT_THAT(refusal("\n"), HasSubstr("no-features"));
  EXPECT_THAT(refusal(good + "a\tb\n"), HasSubstr("row 2: 2 columns, not the 6"));
  EXPECT_THAT(refusal(good + tsv_row("bb", ones() + "\t")), HasSubstr("row 2: 7 columns"));
  EXPECT_THAT(refusal(tsv_row("", ones())), HasSubstr("row 1: an empty id"));
  EXPECT_THAT(refusal(good + good), AllOf(HasSubstr("\"aa\""), HasSubstr("comes twice")));
  EXPECT_THAT(refusal(good + tsv_row("bb", ones() + ones())),
              HasSubstr("viewpoint \"bb\": 2 numbers a view, not 1 as the first"));
  EXPECT_THAT(refusal(tsv_row("aa", ones() + "AAAA")), HasSubstr("196 characters, not those of"));
  EXPECT_THAT(refusal(tsv_row("aa", ones() + "A")), HasSubstr("bad-base64"));
  EXPECT_THAT(refusal(tsv_row("aa", "")), HasSubstr("0 characters"));
  std::string odd = ones();
  odd[7] = '*';
  EXPECT_THAT(refusal(tsv_row("aa", odd)), HasSubstr("features: character 8 is \"*\""));
  std::string infinite = ones();
  infinite.replace(0, 6, "AACAfw");
  EXPECT_THAT(refusal(tsv_row("aa", infinite)), HasSubstr("not-finite"));
  EXPECT_THAT(refusal(tsv_row("aa", ones(), "wide\t480\t60")),
              HasSubstr("image_w: \"wide\", not a number"));
  EXPECT_THAT(refusal(tsv_row("aa", ones(), "640\t480.5\t60")), HasSubstr("bad-camera"));
  EXPECT_THAT(refusal(good + tsv_row("bb", ones(), "640\t480\t75")),
              AllOf(HasSubstr("differing-camera"), HasSubstr("75 degrees")));
}

// tests/fuzz/make_weight_seeds.py wrote these with h5py.
TEST_F(FeatureSetTest, ReadsHdf5OfOthers) {
  for (const char* name : {"f32.h5", "f16_gzip.h5", "f64.h5"}) {
    const FeatureSet set = FeatureSet::open(kSeeds / "feature_hdf5" / name);
    EXPECT_EQ(set.info().type,
              std::string_view(name) == "f16_gzip.h5" ? DType::kFloat16 : DType::kFloat32);
    EXPECT_EQ(set.info().views, kViews);
    EXPECT_EQ(set.info().dimensions, 3U);
    EXPECT_EQ(set.info().camera, Camera{});
    EXPECT_THAT(set.keys(), ElementsAre(FeatureKey{"scan_1", "aa"}, FeatureKey{"scan_1", "bb"}));
    std::vector<float> view(3);
    set.copy_view(1, 35, view);
    EXPECT_THAT(view, ElementsAre(126.25, 126.5, 126.75)) << name;
  }
}

TEST_F(FeatureSetTest, DamagedHdf5IsHarmless) {
  const std::string whole = read_file(kSeeds / "feature_hdf5/f32.h5");
  std::size_t accepted = 0;
  for (std::size_t at = 0; at < whole.size(); at += 29) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
    try {
      const FeatureSet set = FeatureSet::open(write("f.h5", damaged));
      for (const FeatureKey& key : set.keys()) views(set, key);
      ++accepted;
    } catch (const InvalidInput&) {
    }
  }
  EXPECT_GT(accepted, 0U) << "other numbers are no damage that can be seen";
  EXPECT_THAT(refusal_of(write("f.h5", "no HDF5")), HasSubstr("not an HDF5 file"));
  EXPECT_THAT(tests::refusal<FileError>([&] { FeatureSet::open(path("none.h5")); }),
              HasSubstr("No such file"));
}

TEST_F(FeatureSetTest, ManyThreadsMayUseHdf5) {
  const fs::path file = path("f.h5");
  write_set(file, made_info(), keys_of({"aa", "bb"}));
  std::vector<std::thread> threads;
  std::atomic<int> right = 0;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&, i] {
      const fs::path own = path(fmt::format("own{}.h5", i));
      for (int k = 0; k < 20; ++k) {
        write_set(own, made_info(), keys_of({"aa"}));
        right += views(FeatureSet::open(file), {"home_1", "bb"}) == row_of(1) ? 1 : 0;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(right, 80);
}

// --- conversion ---------------------------------------------------------------------------------

TEST_F(FeatureSetTest, EachFormatConvertsIntoEach) {
  const auto keys = keys_of({"aa", "bb"});
  for (const char* from : {"from.safetensors", "from.tsv", "from.h5"}) {
    write_set(path(from), made_info(), keys);
    for (const char* to : {"to.safetensors", "to.tsv", "to.h5"}) {
      convert_features(std::vector{path(from)}, path(to));
      const FeatureSet set = FeatureSet::open(path(to));
      EXPECT_EQ(set.info().camera, made_info().camera);
      for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(views(set, keys[i]), row_of(i)) << from << " " << to;
      }
    }
    convert_features(std::vector{path(from)}, path("half.safetensors"), DType::kFloat16);
    EXPECT_EQ(FeatureSet::open(path("half.safetensors")).info().type, DType::kFloat16);
    EXPECT_EQ(views(FeatureSet::open(path("half.safetensors")), keys[1]), row_of(1));
  }
}

TEST_F(FeatureSetTest, ShardsGoIntoOneFile) {
  const auto keys = keys_of({"aa", "bb", "cc", "dd"});
  write_set(path("1.safetensors"), made_info(), keys_of({"aa", "cc"}), 0);
  write_set(path("2.safetensors"), made_info(DType::kFloat16), keys_of({"bb", "dd"}), 2);
  convert_features(std::vector{path("1.safetensors"), path("2.safetensors")},
                   path("all.safetensors"));
  const FeatureSet set = FeatureSet::open(path("all.safetensors"));
  EXPECT_EQ(set.info().encoder, "home");
  EXPECT_EQ(set.keys().size(), 4U);
  EXPECT_EQ(views(set, keys[2]), row_of(1));
  EXPECT_EQ(views(set, keys[3]), row_of(3));
}

TEST_F(FeatureSetTest, ShardsThatDoNotFitAreRefused) {
  write_set(path("1.h5"), made_info(), keys_of({"aa", "cc"}));
  write_set(path("2.h5"), made_info(), keys_of({"bb", "aa"}));
  FeatureInfo other = made_info();
  other.weights = "fedcba9876543210";
  write_set(path("3.h5"), other, keys_of({"dd"}));
  const auto refusal = [&](const std::vector<fs::path>& from) {
    return tests::refusal<InvalidInput>([&] { convert_features(from, path("all.h5")); });
  };
  EXPECT_THAT(
      refusal({path("1.h5"), path("2.h5")}),
      AllOf(HasSubstr("2.h5: scan \"home_1\", viewpoint \"aa\": is in "), HasSubstr("1.h5, too")));
  EXPECT_THAT(refusal({path("1.h5"), path("3.h5")}),
              AllOf(HasSubstr("weights \"fedcba9876543210\""), HasSubstr("differing-info")));
  EXPECT_FALSE(fs::exists(path("all.h5")));
  EXPECT_THROW(convert_features({}, path("all.h5")), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::features
