#include "enfilade/neural/encoder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "enfilade/features/tensor_file.h"
#include "enfilade/neural/core/weights.h"
#include "enfilade/neural/device.h"
#include "tests/support/encoders.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::neural {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::Field;
using ::testing::HasSubstr;
using tests::encoded;
using tests::numbers;
using tests::python_with;
using tests::refusal;
using tests::relative_difference;
using tests::TemporaryFolder;

const Camera kSmall{96, 64, degrees(60)};

std::vector<float> random_pictures(std::size_t n, const Camera& camera) {
  Rng rng(3);
  std::vector<float> pictures(n * 3 * camera.width * camera.height);
  for (float& value : pictures) value = static_cast<float>(2 * rng.uniform() - 1);
  return pictures;
}

class Torchvision : public ::testing::TestWithParam<const char*> {};

TEST_P(Torchvision, GivesTheSameFeatures) {
  const auto python = python_with("torchvision");
  if (!python) GTEST_SKIP() << "no torchvision for python3: apt-get install python3-torchvision";
  const TemporaryFolder folder("torchvision");
  const std::string command = *python + " '" EN_SOURCE_DIR "/tests/python/torchvision_resnet.py' " +
                              GetParam() + " '" + folder.path().string() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
  const features::TensorFile truth = features::TensorFile::open(folder.path() / "case.safetensors");
  const std::vector<float> pictures = numbers(truth, "pictures");
  // Against float64: what is left is our own rounding in sums of up to 4,608 products, 152 layers
  // deep, which has been 6e-6 at most. tests/python/torchvision_resnet.py says why not more.
  constexpr double kTolerance = 2e-5;
  std::string hash;
  for (const char* weights : {"weights.safetensors", "weights.pth"}) {
    for (const auto preprocessing : {Preprocessing::kTorchvision, Preprocessing::kCaffe}) {
      EncoderConfig config{.name = GetParam(), .weights = folder.path() / weights};
      config.preprocessing = preprocessing;
      const auto encoder = make_encoder(config);
      const bool caffe = preprocessing == Preprocessing::kCaffe;
      const std::vector<float> features = numbers(truth, caffe ? "features_bgr" : "features");
      EXPECT_LE(relative_difference(encoded(*encoder, pictures, 2, kSmall), features), kTolerance)
          << weights << (caffe ? ", caffe" : "");
      if (hash.empty()) hash = encoder->weights_hash();
      EXPECT_EQ(encoder->weights_hash(), hash) << weights;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, Torchvision, ::testing::Values("resnet18", "resnet50", "resnet152"));

TEST(Encoder, ResNetsHaveTheirDimensions) {
  EXPECT_EQ(make_encoder({.name = "resnet18"})->dimensions(), 512U);
  EXPECT_EQ(make_encoder({.name = "resnet50"})->dimensions(), 2048U);
  EXPECT_EQ(make_encoder({.name = "resnet18"})->camera(), (Camera{640, 480, degrees(60)}));
}

TEST(Encoder, BatchesChangeNothingButTheLastBits) {
  for (const char* name : {"resnet18", "home"}) {
    const auto encoder = make_encoder({.name = name});
    const Camera camera = encoder->camera().width == 128 ? encoder->camera() : kSmall;
    const std::vector<float> pictures = random_pictures(5, camera);
    const std::vector<float> together = encoded(*encoder, pictures, 5, camera);
    std::vector<float> apart;
    for (std::size_t i = 0; i < 5; ++i) {
      const auto one = std::span(pictures).subspan(i * pictures.size() / 5, pictures.size() / 5);
      const std::vector<float> features = encoded(*encoder, one, 1, camera);
      apart.insert(apart.end(), features.begin(), features.end());
    }
    // oneDNN may choose another order of sums for another size.
    EXPECT_LE(relative_difference(apart, together), 1e-5) << name;
    EXPECT_FALSE(std::ranges::equal(std::span(together).first(encoder->dimensions()),
                                    std::span(together).last(encoder->dimensions())));
  }
}

TEST(Encoder, CaffesPicturesAreBytesMinusMeans) {
  const auto encoder = make_encoder({.name = "resnet18", .preprocessing = Preprocessing::kCaffe});
  const render::Normalisation n = encoder->normalisation();
  const std::array<double, 3> means{123.2, 115.9, 103.1};  // R G B
  for (std::size_t c = 0; c < 3; ++c) {
    for (const double value : {0.0, 17.0, 255.0}) {
      const double seen = (value / 255 - double{n.mean.at(c)}) / double{n.deviation.at(c)};
      EXPECT_NEAR(seen, value - means.at(c), 1e-4);  // float32 of numbers up to 152
    }
  }
}

TEST(Encoder, RandomWeightsAreThoseOfTheSeed) {
  const auto hash = [](std::uint64_t seed) {
    return make_encoder({.name = "resnet18", .seed = seed})->weights_hash();
  };
  EXPECT_EQ(hash(1), hash(1));
  EXPECT_NE(hash(1), hash(2));
  EXPECT_EQ(hash(1).size(), 16U);
}

TEST(Weights, BfloatsAreReadAsFloats) {
  const TemporaryFolder folder("weights");
  const fs::path file = folder.path() / "weights.safetensors";
  const std::vector<std::uint16_t> halves{0x3FC0, 0xC000};  // the upper ones of 1.5F and -2.0F
  const std::vector<features::NamedArray> arrays{
      {"w", features::DType::kBFloat16, {2}, std::as_bytes(std::span(halves))}};
  features::write_safetensors(file, arrays);
  const std::vector<core::ArraySpec> wanted{{"w", {2}}};
  const core::Weights read = core::read_weights(features::TensorFile::open(file), wanted);
  const float* const values = read.at("w").data_ptr<float>();
  EXPECT_EQ(values[0], 1.5F);
  EXPECT_EQ(values[1], -2.0F);
}

TEST(Encoder, NamesEveryFaultOfAFileAtOnce) {
  const TemporaryFolder folder("weights");
  const fs::path file = folder.path() / "weights.safetensors";
  const std::vector<float> values(3, 1.5F);
  const auto bytes = std::as_bytes(std::span(values));
  const std::vector<float> bad(64, std::nanf(""));
  const std::vector<features::NamedArray> arrays{
      {"conv1.weight", features::DType::kFloat32, {3}, bytes},
      {"bn1.weight", features::DType::kFloat32, {64}, std::as_bytes(std::span(bad))},
      {"bn1.bias", features::DType::kInt32, {64}, std::as_bytes(std::span(bad))},
      {"fc.bias", features::DType::kFloat32, {3}, bytes},
      {"head.bias", features::DType::kFloat32, {3}, bytes}};
  features::write_safetensors(file, arrays);
  try {
    make_encoder({.name = "resnet18", .weights = file});
    FAIL() << "accepted";
  } catch (const InvalidInput& error) {
    const auto& found = error.diagnostics();
    const auto named = [](const char* where, const char* code) {
      return AllOf(Field(&Diagnostic::where, where), Field(&Diagnostic::code, code));
    };
    EXPECT_THAT(found, Contains(named("conv1.weight", "wrong-shape")));
    EXPECT_THAT(found, Contains(named("bn1.weight", "not-finite")));
    EXPECT_THAT(found, Contains(named("bn1.bias", "wrong-type")));
    EXPECT_THAT(found, Contains(named("bn1.running_mean", "missing-array")));
    EXPECT_THAT(found, Contains(named("layer4.1.conv2.weight", "missing-array")));
    EXPECT_THAT(found, Contains(named("head.bias", "surplus-array")));
    // 20 convolutions with 4 arrays of normalisation each; 3 of these 100 are there, and 1 surplus.
    EXPECT_EQ(found.size(), 101U);
  }
}

TEST(Encoder, RefusesWhatItCannotDo) {
  EXPECT_THAT(refusal<LookupError>([] { make_encoder({.name = "vgg"}); }), HasSubstr("resnet152"));
  EXPECT_THAT(refusal<ArgumentError>([] { make_encoder({.name = "resnet18", .device = "tpu"}); }),
              HasSubstr("\"cuda:N\""));
  EXPECT_THAT(
      refusal<FileError>([] { make_encoder({.name = "home", .weights = "/nowhere/at.all"}); }),
      HasSubstr("/nowhere/at.all"));
  const auto encoder = make_encoder({.name = "resnet18"});
  std::vector<float> pictures(std::size_t{3} * 64 * 64), features(512);
  const Camera square{64, 64, degrees(60)}, tiny{16, 16, degrees(60)};
  EXPECT_THAT(refusal<ArgumentError>([&] { encoder->encode(pictures, 2, square, features); }),
              HasSubstr("2 pictures of 3 x 64 x 64 have 24576"));
  EXPECT_THAT(refusal<ArgumentError>(
                  [&] { encoder->encode(pictures, 1, square, std::span(features).first(5)); }),
              HasSubstr("1 pictures have 512 of 512"));
  EXPECT_THAT(refusal<ArgumentError>([&] { encoder->encode(pictures, 1, tiny, features); }),
              HasSubstr("at least 32 x 32"));
  EXPECT_THAT(refusal<ArgumentError>([&] {
                const auto home = make_encoder({.name = "home"});
                home->encode(pictures, 1, square, features);
              }),
              HasSubstr("looks at 128 x 96"));
}

TEST(Encoder, SaysWhyACardCannotBeUsed) {
  const TorchReport torch = examine_torch();
  if (torch.cuda == "works") GTEST_SKIP() << "this machine has a card that libtorch can use";
  EXPECT_THAT(refusal([] { make_encoder({.name = "resnet18", .device = "cuda"}); }),
              HasSubstr("device cuda: libtorch cannot use it"));
}

TEST(Torch, TellsItsBlasAndHowFastItIs) {
  const TorchReport torch = examine_torch();
  EXPECT_GT(torch.product_speed, 0.1);  // a processor of 1995
  EXPECT_GE(torch.threads, 1);
  EXPECT_TRUE(torch.blas.empty() || fs::exists(torch.blas)) << torch.blas;
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural
