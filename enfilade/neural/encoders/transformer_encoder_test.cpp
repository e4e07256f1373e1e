#include "enfilade/neural/encoders/transformer_encoder.h"

#include <ATen/ATen.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "enfilade/features/tensor_file.h"
#include "tests/support/encoders.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::neural::encoders {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Field;
using ::testing::HasSubstr;
using tests::encoded;
using tests::numbers;
using tests::python_with;
using tests::refusal;
using tests::relative_difference;
using tests::TemporaryFolder;

// --- against the code of others ---

struct Other {
  const char* name;      // for the script
  const char* encoder;   // ours
  const char* packages;  // of Python
  std::uint32_t shorter;
};

std::ostream& operator<<(std::ostream& out, const Other& other) { return out << other.name; }

class Others : public ::testing::TestWithParam<Other> {};

TEST_P(Others, GiveTheSameFeatures) {
  const Other& other = GetParam();
  const auto python = python_with(other.packages);
  if (!python) GTEST_SKIP() << "no Python with all of " << other.packages;
  const TemporaryFolder folder("transformers");
  const std::string command = *python +
                              " '" EN_SOURCE_DIR "/tests/python/transformer_encoders.py' " +
                              other.name + " '" + folder.path().string() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
  const features::TensorFile truth = features::TensorFile::open(folder.path() / "case.safetensors");
  const std::vector<float> pictures = numbers(truth, "pictures");
  const Camera camera{320, 240, degrees(60)};

  const at::Tensor resized = PictureResize(camera, other.shorter, 224).apply(pictures, 2);
  const std::span<const float> seen(resized.data_ptr<float>(),
                                    static_cast<std::size_t>(resized.numel()));
  EXPECT_TRUE(std::ranges::equal(seen, numbers(truth, "resized")));

  const bool logits = other.encoder == std::string("vit-b-16");
  const auto encoder = make_encoder(
      {.name = other.encoder, .weights = folder.path() / "weights.pth", .logits = logits});
  // Against float64: what is left is our rounding, 12 blocks deep.
  constexpr double kTolerance = 1e-5;
  const std::vector<float> features = numbers(truth, "features");
  ASSERT_EQ(features.size(), 2 * encoder->dimensions());
  const double difference = relative_difference(encoded(*encoder, pictures, 2, camera), features);
  EXPECT_LE(difference, kTolerance);
  RecordProperty("difference", ::testing::PrintToString(difference));
}

INSTANTIATE_TEST_SUITE_P(
    All, Others,
    ::testing::Values(Other{"vit-b-16", "vit-b-16", "timm, torchvision", 248},
                      Other{"clip-vit-b-16", "clip-vit-b-16", "clip, torchvision", 224},
                      Other{"clip-vit-b-32", "clip-vit-b-32", "clip, torchvision", 224},
                      Other{"transformers", "clip-vit-b-32", "transformers, torchvision", 224}));

// --- alone ---

TEST(PictureResize, KeepsWhatItCannotMakeSmaller) {
  // The middle 4 x 4 of 8 x 6 pixels, none of them mixed with others.
  const Camera camera{8, 6, degrees(60)};
  std::vector<float> pictures(std::size_t{3} * 8 * 6);
  for (std::size_t i = 0; i < pictures.size(); ++i) pictures[i] = static_cast<float>(i);
  const at::Tensor out = PictureResize(camera, 6, 4).apply(pictures, 1);
  EXPECT_EQ(out[0][0][0][0].item<float>(), 8 + 2);
  EXPECT_EQ(out[0][0][3][3].item<float>(), 4 * 8 + 5);
  EXPECT_EQ(out[0][2][0][0].item<float>(), 2 * 48 + 8 + 2);
}

TEST(PictureResize, OneColourStaysItself) {
  for (const Camera& camera : {Camera{640, 480, degrees(60)}, Camera{33, 97, degrees(60)}}) {
    const std::vector<float> pictures(std::size_t{3} * camera.width * camera.height, 201);
    const at::Tensor out = PictureResize(camera, 248, 224).apply(pictures, 1);
    EXPECT_TRUE((out == 201).all().item<bool>()) << camera.width;
  }
}

TEST(TransformerEncoder, HasItsSizesAndCutsThePicturesMiddleOut) {
  const auto encoder = make_encoder({.name = "clip-vit-b-32", .seed = 3});
  EXPECT_EQ(encoder->dimensions(), 512U);
  EXPECT_EQ(encoder->preprocessing(), "clip");
  EXPECT_EQ(encoder->camera(), (Camera{640, 480, degrees(60)}));
  const render::Normalisation n = encoder->normalisation();
  EXPECT_FLOAT_EQ((1 - n.mean[0]) / n.deviation[0], 255);

  const Camera camera{96, 64, degrees(60)};
  Rng rng(3);
  std::vector<float> pictures(std::size_t{5} * 3 * 96 * 64);
  for (float& value : pictures) value = static_cast<float>(rng.below(256));
  const std::vector<float> together = encoded(*encoder, pictures, 5, camera);
  const std::size_t picture = pictures.size() / 5;
  const auto last = std::span(pictures).last(picture);
  // Another size of batch, another order of sums.
  const auto alone = encoded(*encoder, last, 1, camera);
  EXPECT_LE(relative_difference(alone, std::span(together).last(512)), 1e-5);
  EXPECT_FALSE(std::ranges::equal(std::span(together).first(512), alone));
  // 64 of 96 columns are in the middle; the kernel of an enlarged picture reaches two beyond.
  const auto repaint = [&](std::size_t column) {
    for (std::size_t y = 0; y < 3 * 64; ++y) last[y * 96 + column] = 255 - last[y * 96 + column];
    return encoded(*encoder, last, 1, camera);
  };
  EXPECT_EQ(repaint(12), alone);
  EXPECT_NE(repaint(20), alone);
}

TEST(TransformerEncoder, GivesClassScoresBehindTheFeatures) {
  const auto with = make_encoder({.name = "vit-b-16", .logits = true});
  EXPECT_EQ(with->dimensions(), 1768U);
  EXPECT_EQ(with->preprocessing(), "vit");
  EXPECT_THAT(refusal<ArgumentError>([] { make_encoder({.name = "resnet18", .logits = true}); }),
              HasSubstr("encoder \"resnet18\" gives no class scores; vit-b-16 is expected"));
}

// Faults of a file with one array of a wrong shape and one that nobody asked for.
std::vector<Diagnostic> faults(EncoderConfig config, const char* wrong, const char* surplus) {
  const TemporaryFolder folder("weights");
  config.weights = folder.path() / "weights.safetensors";
  const std::vector<float> values(3, 1.5F);
  const auto bytes = std::as_bytes(std::span(values));
  const std::vector<features::NamedArray> arrays{
      {wrong, features::DType::kFloat32, {3}, bytes},
      {surplus, features::DType::kFloat32, {3}, bytes},
      {"head.bias", features::DType::kFloat32, {3}, bytes},
      {"transformer.resblocks.0.ln_1.bias", features::DType::kFloat32, {3}, bytes}};
  features::write_safetensors(config.weights, arrays);
  try {
    make_encoder(config);
  } catch (const InvalidInput& error) {
    return error.diagnostics();
  }
  return {};
}

auto fault(const char* where, const char* code) {
  return AllOf(Field(&Diagnostic::where, where), Field(&Diagnostic::code, code));
}

TEST(TransformerEncoder, NamesEveryFaultOfTimmsWeights) {
  const auto found = faults({.name = "vit-b-16"}, "cls_token", "blocks.12.norm1.bias");
  EXPECT_THAT(found, Contains(fault("cls_token", "wrong-shape")));
  EXPECT_THAT(found, Contains(fault("blocks.12.norm1.bias", "surplus-array")));
  EXPECT_THAT(found, Contains(fault("blocks.11.attn.qkv.weight", "missing-array")));
  // 2 tokens, 2 of patches, 12 blocks of 12, 2 at the end; the text's array is surplus too, and
  // the head is only with class scores.
  EXPECT_EQ(found.size(), 2U + 2 + 144 + 2 + 2);
  EXPECT_THAT(faults({.name = "vit-b-16", .logits = true}, "cls_token", "x"),
              Contains(fault("head.bias", "wrong-shape")));
}

TEST(TransformerEncoder, NamesEveryFaultOfClipsWeights) {
  const auto found = faults({.name = "clip-vit-b-32"}, "visual.proj", "visual.layer1.0.bn1.bias");
  EXPECT_THAT(found, Contains(fault("visual.proj", "wrong-shape")));
  EXPECT_THAT(found, Contains(fault("visual.layer1.0.bn1.bias", "surplus-array")));  // a ResNet's
  EXPECT_THAT(found, Contains(fault("visual.class_embedding", "missing-array")));
  EXPECT_EQ(found.size(), 2U + 1 + 2 + 144 + 2 + 1 + 1);  // that of the text may be there
  const auto other = faults({.name = "clip-vit-b-16"}, "visual_projection.weight",
                            "vision_model.encoder.layers.12.mlp.fc1.bias");
  EXPECT_THAT(other, Contains(fault("visual_projection.weight", "wrong-shape")));
  EXPECT_THAT(other, Contains(fault("vision_model.encoder.layers.3.self_attn.k_proj.bias",
                                    "missing-array")));
  EXPECT_THAT(
      other, Contains(fault("vision_model.embeddings.position_embedding.weight", "missing-array")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural::encoders
