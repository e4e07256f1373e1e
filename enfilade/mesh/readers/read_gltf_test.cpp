#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <numbers>

#include "enfilade/core/file.h"
#include "enfilade/image/codecs.h"
#include "enfilade/mesh/read_mesh.h"
#include "tests/support/photo_files.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::mesh::readers {
namespace EN_UNIT {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;

template <class T>
std::string raw(std::initializer_list<T> values) {
  std::string out;
  for (const T value : values) {
    out.append(reinterpret_cast<const char*>(&value), sizeof(T));  // little-endian here
  }
  return out;
}

std::string glb(std::string json, std::string binary) {
  while (json.size() % 4 != 0) json += ' ';
  while (binary.size() % 4 != 0) binary += '\0';
  const auto size = [](std::size_t n) { return static_cast<std::uint32_t>(n); };
  std::string out = "glTF" + raw<std::uint32_t>({2, size(28 + json.size() + binary.size())});
  out += raw<std::uint32_t>({size(json.size()), 0x4E4F534A}) + json;
  out += raw<std::uint32_t>({size(binary.size()), 0x004E4942}) + binary;
  return out;
}

/// Replaces the first of what is there; a test whose edit finds nothing fails.
std::string with(std::string text, std::string_view old, std::string_view fresh) {
  const std::size_t at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return at == std::string::npos ? text : text.replace(at, old.size(), fresh);
}

/// Four corners of 2 x 2 (accessor 0), as 16-bit indices (1): 0 1 2 3 0 2.
constexpr const char* kJson = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
"nodes":[{"mesh":0,"name":"floor"}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},
{"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":12},
{"buffer":0,"byteOffset":60,"byteLength":32}],
"buffers":[{"byteLength":92}]})";
std::string binary() {
  return raw<float>({0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0}) + raw<std::uint16_t>({0, 1, 2, 3, 0, 2}) +
         raw<float>({0, 0, 1, 0, 1, 1, 0, 1});
}
ReadResult parse(const std::string& json, const std::string& bytes = binary()) {
  return parse_mesh(glb(json, bytes), "a.glb");
}
std::vector<std::string> codes(const ReadResult& r) {
  std::vector<std::string> out;
  for (const Diagnostic& d : r.warnings) out.push_back(d.code);
  return out;
}

TEST(ReadGltf, ReadsTrianglesWithYUp) {
  const ReadResult r = parse(kJson);
  EXPECT_THAT(r.mesh.triangles, ElementsAre(std::array{0U, 1U, 2U}, std::array{3U, 0U, 2U}));
  EXPECT_EQ(r.mesh.positions[2], (Vec3f{2, 0, 2})) << "y up becomes z up, z becomes -y";
  ASSERT_EQ(r.mesh.objects.size(), 1U);
  EXPECT_EQ(r.mesh.objects[0].name, "floor");
  EXPECT_THAT(r.mesh.triangle_object, ElementsAre(0, 0));
  EXPECT_EQ(r.mesh.materials[0].colour, (Vec3f{1, 1, 1}));
  EXPECT_THAT(r.warnings, IsEmpty());
  ReadOptions options;
  options.up = UpAxis::kZ;
  options.scale = 3;
  EXPECT_EQ(parse_mesh(glb(kJson, binary()), "a.glb", options).mesh.positions[2], (Vec3f{6, 6, 0}));
}

TEST(ReadGltf, CutAnywhereIsRefused) {
  const std::string whole = glb(kJson, binary());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const std::string cut = whole.substr(0, size);  // its own, so that a sanitizer sees its end
    EXPECT_THROW(parse_mesh(cut, "a.glb"), InvalidInput) << size;
    // And if the lengths say so, too.
    if (size < 12) continue;
    const std::string length = raw<std::uint32_t>({static_cast<std::uint32_t>(size)});
    EXPECT_THROW(parse_mesh(std::string(cut).replace(8, 4, length), "a.glb"), InvalidInput) << size;
  }
}

TEST(ReadGltf, ReadsStripsAndFans) {
  const std::string indices = R"("indices":1)";
  const Mesh strip = parse(with(with(kJson, indices, R"("mode":5)"), "\"floor\"", "\"\"")).mesh;
  // 0 1 2, then 1 3 2: both seen from the same side.
  EXPECT_EQ(strip.triangles.size(), 2U);
  EXPECT_EQ(strip.positions[strip.triangles[1][1]], (Vec3f{0, 0, 2}));
  EXPECT_EQ(strip.objects[0].name, "node 0");
  const Mesh fan = parse(with(kJson, indices, R"("mode":6)")).mesh;
  EXPECT_THAT(fan.triangles, ElementsAre(std::array{0U, 1U, 2U}, std::array{0U, 2U, 3U}));
  const ReadResult lines = parse(
      with(kJson, R"({"attributes")", R"({"attributes":{"POSITION":0},"mode":1},{"attributes")"));
  EXPECT_THAT(codes(lines), ElementsAre("left-out"));
}

TEST(ReadGltf, NodesMoveTurnAndScale) {
  // Child: scaled by (1, 2, 1), turned by 90 degrees about z, moved by (0, 0, 5); parent: a matrix
  // that moves by (10, 0, 0). (2, 2, 0) -> (2, 4, 0) -> (-4, 2, 0) -> (6, 2, 5).
  const double half = std::numbers::sqrt2 / 2;
  const std::string nodes = fmt::format(
      R"("nodes":[{{"children":[1],"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,10,0,0,1]}},
      {{"mesh":0,"name":"floor","scale":[1,2,1],"rotation":[0,0,{0},{0}],"translation":[0,0,5]}}],)",
      half);
  const std::string json = with(with(with(kJson, R"("nodes":[{"mesh":0,"name":"floor"}],)", nodes),
                                     R"("POSITION":0)", R"("POSITION":0,"NORMAL":2)"),
                                R"("accessors":[)", R"("accessors":[)");
  const std::string accessors = with(json, R"("type":"SCALAR"})",
                                     R"("type":"SCALAR"},{"bufferView":3,"componentType":5126,
                                     "count":4,"type":"VEC3"})");
  const std::string all = with(with(accessors, R"("byteLength":32})",
                                    R"("byteLength":32},{"buffer":0,"byteOffset":92,
                                    "byteLength":48})"),
                               R"("byteLength":92)", R"("byteLength":140)");
  const Mesh m = parse(all, binary() + raw<float>({1, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0})).mesh;
  const Vec3f p = m.positions[2];  // with y up: (6, 2, 5)
  EXPECT_NEAR(p.x, 6, 1e-6);
  EXPECT_NEAR(p.y, -5, 1e-6);
  EXPECT_NEAR(p.z, 2, 1e-6);
  // A normal is squeezed where its surface is stretched: (1, 1/2, 0), turned (-1/2, 1, 0), z up.
  const Vec3f n = m.normals[0][0];
  EXPECT_NEAR(n.x, -0.5 / std::sqrt(1.25), 1e-6);
  EXPECT_NEAR(n.y, 0, 1e-6);
  EXPECT_NEAR(n.z, 1 / std::sqrt(1.25), 1e-6);
  const Vec3f flat = m.normals[0][2];  // a normal of no length: the triangle's own
  EXPECT_NEAR(std::abs(flat.y), 1, 1e-6);
}

TEST(ReadGltf, SparseAccessorsReplaceSome) {
  const std::string json =
      with(kJson, R"("count":4,"type":"VEC3")",
           R"("count":4,"type":"VEC3","sparse":{"count":1,"indices":{"bufferView":1,
           "byteOffset":6,"componentType":5123},"values":{"bufferView":2}})");
  const Mesh m = parse(json).mesh;  // index 3 becomes the first three numbers of view 2: 0 0 1
  EXPECT_EQ(m.positions[3], (Vec3f{0, -1, 0}));
  EXPECT_THAT(
      [&] {
        parse(with(json, R"("byteOffset":6,"componentType":5123)",
                   R"("byteOffset":8,"componentType":5125)"));
      },
      ThrowsMessage<InvalidInput>(HasSubstr("sparse index")));
}

/// With one more attribute of four vertices, without a view of a buffer unless `accessor` has one.
std::string with_attribute(const std::string& name, const std::string& accessor) {
  return with(with(kJson, R"("POSITION":0)", R"("POSITION":0,")" + name + R"(":2)"),
              R"("type":"SCALAR"})", R"("type":"SCALAR"},{)" + accessor + "}");
}

TEST(ReadGltf, AccessorsWithoutViewsAreZeros) {
  const ReadResult r =
      parse(with_attribute("NORMAL", R"("componentType":5126,"count":4,"type":"VEC3")"));
  EXPECT_THAT(r.warnings, IsEmpty());
  EXPECT_EQ(r.mesh.normals[0][0].y, face_normal(r.mesh, 0).y) << "of no length: the face's";
  // Sparse ones alone: the normal of vertex 3 is (0, 0, 1), as at the start of view 2.
  const ReadResult sparse = parse(with_attribute(
      "NORMAL", R"("componentType":5126,"count":4,"type":"VEC3","sparse":{"count":1,"indices":
      {"bufferView":1,"byteOffset":6,"componentType":5123},"values":{"bufferView":2}})"));
  EXPECT_EQ(sparse.mesh.normals[1][0], (Vec3f{0, -1, 0}));
}

TEST(ReadGltf, IndicesWithoutAViewAreZeros) {
  const std::string none = R"({"componentType":5123,"count":6,"type":"SCALAR"})";
  const std::string given = R"({"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"})";
  EXPECT_THAT(codes(parse(with(kJson, given, none))),
              ElementsAre("absurd-size", "degenerate-triangles"));
  // Indices 0 and 1 become those at byte 48 of the buffer, and so on.
  const std::string sparse = with(none, "}", R"(,"sparse":{"count":2,"indices":{"bufferView":1,
      "componentType":5123},"values":{"bufferView":1,"byteOffset":2}}})");
  const ReadResult r = parse(with(kJson, given, sparse));
  EXPECT_THAT(r.mesh.triangles, ElementsAre(std::array{0U, 1U, 2U}, std::array{2U, 2U, 2U}));
  const std::string text = with(with(kJson, given, none), R"({"byteLength":92})",
                                R"({"byteLength":92,"uri":"data:application/octet-stream;base64,)" +
                                    std::string(123, 'A') + R"(="})");
  EXPECT_EQ(parse_mesh(text, "a.gltf").mesh.triangles.size(), 2U);
}

TEST(ReadGltf, FaultsOfWhatAShapeCanDoWithoutAreWarnings) {
  const auto warned = [](const std::string& json, const char* code, const char* message) {
    const ReadResult r = parse(json);
    ASSERT_THAT(codes(r), ElementsAre(code));
    EXPECT_THAT(r.warnings[0].message, HasSubstr(message));
    EXPECT_EQ(r.mesh.triangles.size(), 2U);
  };
  warned(with_attribute("NORMAL", R"("componentType":5126,"count":3,"type":"VEC3")"), "list-length",
         "3 vertices, not 4: NORMAL is left out");
  warned(with_attribute("COLOR_0", R"("componentType":5126,"count":4,"type":"VEC2")"),
         "bad-accessor", "COLOR_0 of 2 numbers");
  warned(with(with_attribute("NORMAL", R"("componentType":5126,"count":4,"type":"VEC3")"),
              R"("NORMAL":2)", R"("NORMAL":9)"),
         "bad-index", "only 3 are there: NORMAL is left out");
  warned(with(kJson, R"("POSITION":0})", R"("POSITION":0},"material":3)"), "bad-index",
         "material 3 of 0");
}

TEST(ReadGltf, PositionsThatNoFaceUsesNeedNotBeFinite) {
  const std::string nan = raw<float>({std::numeric_limits<float>::quiet_NaN()});
  const std::string indices = raw<std::uint16_t>({0, 2, 3, 3, 0, 2});
  const ReadResult r =
      parse(kJson, binary().replace(12, 4, nan).replace(48, indices.size(), indices));
  EXPECT_EQ(r.mesh.positions.size(), 3U) << "those that faces use";
  EXPECT_EQ(r.mesh.triangles.size(), 2U);
}

TEST(ReadGltf, NumbersThatAreNotFiniteAreWarnings) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::string odd = raw<float>({nan, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
  const std::string view = R"("bufferView":3,"componentType":5126,"count":4,"type":"VEC3")";
  for (const char* name : {"NORMAL", "COLOR_0"}) {
    const std::string json =
        with(with(with_attribute(name, view), R"("byteLength":32})",
                  R"("byteLength":32},{"buffer":0,"byteOffset":92,"byteLength":48})"),
             R"("byteLength":92)", R"("byteLength":140)");
    const ReadResult r = parse(json, binary() + odd);
    EXPECT_THAT(codes(r), ElementsAre("not-finite")) << name;
    EXPECT_THAT(r.warnings[0].message, HasSubstr("1 "));
  }
}

TEST(ReadGltf, ManyFaultsOfOneKindAreOneWarning) {
  const std::string primitive = R"({"attributes":{"POSITION":0,"NORMAL":9},"material":3})";
  const ReadResult r =
      parse(with(kJson, R"("primitives":[)",
                 R"("primitives":[)" + primitive + "," + primitive + "," + primitive + ","));
  EXPECT_THAT(codes(r), ElementsAre("bad-index", "bad-index"));
  for (const Diagnostic& d : r.warnings) EXPECT_THAT(d.message, HasSubstr("and 2 more like it"));
}

TEST(ReadGltf, ColoursOfBytesAreWarnings) {
  const ReadResult r = parse(
      with_attribute("COLOR_0", R"("bufferView":0,"componentType":5126,"count":4,"type":"VEC3")"));
  ASSERT_THAT(codes(r), ElementsAre("bad-value"));  // corners at 2 m as colours
  EXPECT_THAT(r.warnings[0].message, HasSubstr("3 colours are far above 1"));
}

TEST(ReadGltf, BuffersAreFallbacksOnlyIfTheySaySo) {
  const ReadResult r = parse(
      with(kJson, R"({"byteLength":92})",
           R"({"byteLength":92,"extensions":{"EXT_meshopt_compression":{"fallback":false}}})"));
  EXPECT_EQ(r.mesh.triangles.size(), 2U);
}

TEST(ReadGltf, RequiredExtensionsOfLooksAreWarnings) {
  for (const char* name : {"KHR_technique_webgl", "KHR_techniques_webgl", "KHR_materials_unlit",
                           "KHR_materials_made_up", "EXT_texture_astc", "MSFT_texture_dds",
                           "GOOGLE_texture_settings", "VRMC_materials_mtoon"}) {
    const ReadResult r =
        parse(with(kJson, "\"scene\":0",
                   R"("scene":0,"extensionsRequired":[")" + std::string(name) + R"("])"));
    EXPECT_THAT(codes(r), ElementsAre("left-out")) << name;
    EXPECT_THAT(r.warnings[0].message, HasSubstr(name));
    EXPECT_EQ(r.mesh.triangles.size(), 2U);
  }
}

TEST(ReadGltf, ReadsSharesOfOneAsColours) {
  // View 2 read as bytes: floats 0, 0, 1 are 00 00 00 00 00 00 00 00 00 00 80 3F.
  const std::string json =
      with(with(kJson, R"("POSITION":0)", R"("POSITION":0,"COLOR_0":2)"), R"("type":"SCALAR"})",
           R"("type":"SCALAR"},{"bufferView":2,"componentType":5121,"normalized":true,"count":4,
           "type":"VEC4"})");
  const Mesh m = parse(json).mesh;
  EXPECT_EQ(m.colours[0], (Vec3f{0, 0, 0}));
  EXPECT_FLOAT_EQ(m.colours[2].z, 128.0F / 255) << "linear already";
}

/// With a material (its inside is given) whose texture is the picture, and texture points.
std::string textured_json(const std::string& material, std::size_t picture_bytes) {
  std::string json =
      with(kJson, R"("POSITION":0},)", R"("POSITION":0,"TEXCOORD_0":2},"material":0,)");
  json = with(json, R"("type":"SCALAR"})", R"("type":"SCALAR"},{"bufferView":2,
      "componentType":5126,"count":4,"type":"VEC2"})");
  json = with(json, R"("byteLength":32})",
              fmt::format(R"("byteLength":32}},{{"buffer":0,"byteOffset":92,"byteLength":{}}})",
                          picture_bytes));
  json = with(json, R"("byteLength":92)", fmt::format(R"("byteLength":{})", 92 + picture_bytes));
  return with(json, R"("scene":0)",
              R"("scene":0,"images":[{"bufferView":3,"mimeType":"image/png"}],
              "textures":[{"source":0}],"materials":[)" +
                  material + "]");
}
std::string picture(std::uint32_t channels) {
  image::Image8 out(2, 1, channels);
  for (std::size_t i = 0; i < out.pixels.size(); ++i) {
    out.pixels[i] = static_cast<std::uint8_t>(255 * (i / channels));  // one black, one white
  }
  const auto bytes = image::encode_png(out);
  return {bytes.begin(), bytes.end()};
}

TEST(ReadGltf, ReadsMaterials) {
  const std::string png = picture(4);
  const std::string material = R"({"name":"leaf","pbrMetallicRoughness":{
      "baseColorFactor":[0.5,0.25,1,0.5],"baseColorTexture":{"index":0,
      "extensions":{"KHR_texture_transform":{"offset":[0,1],"rotation":1.5707963267948966,
      "scale":[0.5,0.5]}}}},"emissiveFactor":[1,0.5,0],"emissiveTexture":{"index":0},
      "alphaMode":"MASK","alphaCutoff":0.25,
      "extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":4}}})";
  const ReadResult r = parse(textured_json(material, png.size()), binary() + png);
  const Material& m = r.mesh.materials[0];
  EXPECT_EQ(m.name, "leaf");
  EXPECT_EQ(m.colour, (Vec3f{0.5F, 0.25F, 1}));
  EXPECT_EQ(m.emission, (Vec3f{2, 1, 0})) << "times 4, times the mean of black and white";
  EXPECT_EQ(m.texture.channels, 4U);
  EXPECT_EQ(m.cutout, 0.5F) << "the texture's alpha is halved before it is compared";
  EXPECT_THAT(m.texture_file, HasSubstr("a.glb#images[0]"));
  EXPECT_THAT(codes(r), ElementsAre("mean-emission"));
  // The example of KHR_texture_transform: the lower left quarter, turned. (1, 0) is the picture's
  // (0, 1 - 0.5).
  EXPECT_NEAR(r.mesh.texture_points[0][1].u, 0, 1e-6);
  EXPECT_NEAR(r.mesh.texture_points[0][1].v, 0.5, 1e-6);
}

// As a phone stores it: lying, with an EXIF orientation. OBJ's textures have the same decoder.
TEST(ReadGltf, TexturesAreTurnedByExif) {
  const std::string material = R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})";
  image::Image8 stored(16, 8, 3);
  std::fill_n(stored.pixels.begin(), stored.pixels.size() / 2, std::uint8_t{255});
  const std::string jpeg = tests::with_orientation(tests::jpeg_of(stored), 6);
  const ReadResult r = parse(textured_json(material, jpeg.size()), binary() + jpeg);
  const image::Image8& texture = r.mesh.materials[0].texture;
  ASSERT_EQ(texture.width, 8U);
  ASSERT_EQ(texture.height, 16U);
  EXPECT_LT(texture.at(1, 8)[0], 5);
  EXPECT_GT(texture.at(6, 8)[0], 250) << "the stored top is at the right";
  ASSERT_THAT(codes(r), ElementsAre("orientation"));
  EXPECT_EQ(r.warnings[0].severity, Severity::kNote);
}

TEST(ReadGltf, TexturesMayHaveSixteenBits) {
  const std::string png = tests::colour_of_sixteen_bits();
  const std::string material = R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})";
  const ReadResult r = parse(textured_json(material, png.size()), binary() + png);
  const image::Image8& texture = r.mesh.materials[0].texture;
  ASSERT_EQ(texture.width, 16U);
  EXPECT_EQ(texture.at(15, 7)[1], 255);
  EXPECT_EQ(texture.at(15, 7)[2], 128);
}

TEST(ReadGltf, TexturesHaveTheNameOfTheFileThatWasRead) {
  const tests::TemporaryFolder made("gltf");
  const std::string png = picture(3);
  const std::string json = with(
      textured_json(R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})", png.size()),
      R"("bufferView":3,)", R"("uri":"an%20oak.png",)");
  write_file_atomically(made.path() / "a.glb", glb(json, binary() + png));
  write_file_atomically(made.path() / "An Oak.PNG", png);
  const ReadResult r = read_mesh(made.path() / "a.glb");
  EXPECT_THAT(codes(r), ElementsAre("moved-file"));
  EXPECT_EQ(r.mesh.materials[0].texture_file, (made.path() / "An Oak.PNG").string());
}

TEST(ReadGltf, AlphaThatNobodyAskedForIsDropped) {
  const std::string png = picture(4);
  const std::string material = R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})";
  const ReadResult r = parse(textured_json(material, png.size()), binary() + png);
  EXPECT_EQ(r.mesh.materials[0].texture.channels, 3U);
  EXPECT_EQ(r.mesh.materials[0].texture.at(1, 0)[2], 255);
  EXPECT_EQ(r.mesh.texture_points[0][1].u, 1);
  EXPECT_EQ(r.mesh.texture_points[0][2].v, 1) << "v goes down in glTF as here";
}

TEST(ReadGltf, TexturePointsThatAreNotFiniteAreWarnings) {
  const std::string png = picture(3);
  const std::string nan = raw<float>({std::numeric_limits<float>::quiet_NaN()});
  const std::string material = R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})";
  const ReadResult r =
      parse(textured_json(material, png.size()), binary().replace(68, 4, nan) + png);
  EXPECT_THAT(codes(r), ElementsAre("not-finite"));
  EXPECT_EQ(r.mesh.texture_points[0][1].u, 0);
}

TEST(ReadGltf, MissingAndBrokenTexturesAreWarnings) {
  const std::string png = picture(3);
  const std::string json = textured_json(
      R"({"pbrMetallicRoughness":{"baseColorFactor":[1,0,0,1],"baseColorTexture":{"index":0}}})",
      png.size());
  const auto warned = [&](const std::string& text, const std::string& bytes) {
    const ReadResult r = parse(text, bytes);
    EXPECT_TRUE(r.mesh.materials[0].texture.pixels.empty());
    EXPECT_EQ(r.mesh.materials[0].colour, (Vec3f{1, 0, 0}));
    EXPECT_THAT(codes(r), ElementsAre("missing-texture"));
  };
  warned(json, binary() + png.substr(0, png.size() - 9) + std::string(9, 'x'));
  warned(json, binary() + std::string(png.size(), 'x'));
  warned(with(json, R"({"index":0})", R"({"index":7})"), binary() + png);
  warned(with(json, R"("source":0)", R"("source":3)"), binary() + png);
  warned(with(json, R"("source":0)", R"("name":"webp")"), binary() + png);
  warned(with(json, R"("bufferView":3,)", R"("uri":"gone.png",)"), binary() + png);
  try {
    warned(with(json, R"("byteOffset":92)", R"("byteOffset":9999999)"), binary() + png);
  } catch (const InvalidInput& e) {  // what tinygltf 2.9 makes of it
    EXPECT_THAT(e.what(),
                ::testing::AllOf(HasSubstr("a.glb: image[0] bufferView"), HasSubstr("[bad-gltf]")));
  }
}

TEST(ReadGltf, BasisTexturesAreLeftOutOnce) {
  const std::string png = picture(3);
  const std::string material = R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}},
      {"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})";
  const std::string json =
      with(with(textured_json(material, png.size()), R"([{"source":0}])",
                R"([{"extensions":{"KHR_texture_basisu":{"source":0}}}])"),
           "\"scene\":0", R"("scene":0,"extensionsRequired":["KHR_texture_basisu"])");
  const ReadResult r = parse(json, binary() + png);
  EXPECT_EQ(r.mesh.triangles.size(), 2U);
  ASSERT_THAT(codes(r), ElementsAre("left-out"));
  EXPECT_THAT(r.warnings[0].message, HasSubstr("1 textures in KHR_texture_basisu"));
  EXPECT_THAT(r.warnings[0].message, HasSubstr("gltf-transform"));
}

TEST(ReadGltf, NamesEachFault) {
  const auto edit = [](std::string_view old, std::string_view fresh) {
    return [=] { parse(with(kJson, old, fresh)); };
  };
  const auto says = [](const char* text) { return ThrowsMessage<InvalidInput>(HasSubstr(text)); };
  EXPECT_THAT(edit("\"2.0\"", "\"1.0\""), says("$.asset.version: \"1.0\", not 2.x"));
  EXPECT_THAT(edit("\"2.0\"", "1.0"), says("$.asset.version: a number, as in files of glTF 1.0"));
  EXPECT_THAT(edit("\"scene\":0", R"("extensionsRequired":["EXT_own_geometry"])"),
              says("\"EXT_own_geometry\" is required, but not known here"));
  EXPECT_THAT(edit("{\"asset\"", "{,\"asset\""), says("a.glb"));
  EXPECT_THAT(edit("\"scene\":0", "\"scene\":1"), says("$.scene: 1 of 1"));
  EXPECT_THAT(edit("[{\"nodes\":[0]}]", "[{\"nodes\":[4]}]"), says("$.nodes[4]"));
  EXPECT_THAT(edit("\"mesh\":0", "\"mesh\":3"), says("$.meshes[3]: only 1"));
  EXPECT_THAT(edit("\"mesh\":0", "\"mesh\":0,\"children\":[0]"), says("a child of two nodes"));
  EXPECT_THAT(edit("\"mesh\":0", "\"mesh\":0,\"rotation\":[0,0,0,0]"), says("[not-finite]"));
  EXPECT_THAT(edit("\"POSITION\":0", "\"POSITION\":9"), says("$.accessors[9]: only 2"));
  EXPECT_THAT(edit("\"POSITION\":0", "\"NORMAL\":0"), says("no POSITION"));
  EXPECT_THAT(edit("\"POSITION\":0", "\"POSITION\":1"), says("POSITION of 1 numbers"));
  EXPECT_THAT(edit("\"indices\":1", "\"indices\":0"), says("indices that are not unsigned"));
  EXPECT_THAT(edit("\"indices\":1", "\"indices\":1,\"mode\":7"), says("mode 7"));
  EXPECT_THAT(edit("5126,\"count\":4", "5126,\"count\":5"), says("$.accessors[0]: 5 items"));
  EXPECT_THAT(edit("5126,\"count\":4", "5126,\"count\":3"), says("vertex 3 of 3"));
  EXPECT_THAT(edit("5126,\"count\":4", "5126,\"count\":0"), says("a count of 0"));
  EXPECT_THAT(edit("5126,\"count\":4", "5126,\"count\":1000000000000"),
              says("1000000000000 items"));
  EXPECT_THAT(edit("5126", "5130"), says("component type 5130"));
  EXPECT_THAT(edit("{\"bufferView\":0,\"componentType\":5126,\"count\":4",
                   "{\"componentType\":5126,\"count\":1000000000"),
              says("1000000000 items of zeros, more than"));
  EXPECT_THAT(edit("{\"bufferView\":0,\"componentType\":5126,\"count\":4",
                   "{\"componentType\":5126,\"count\":2000000"),
              says("2000000 items of zeros, more than"));
  EXPECT_THAT(edit("{\"bufferView\":0", "{\"bufferView\":8"), says("buffer view 8: only 3"));
  EXPECT_THAT(edit("{\"bufferView\":0", "{\"byteOffset\":4,\"bufferView\":0"),
              says("4 items from"));
  EXPECT_THAT(edit("{\"bufferView\":0", "{\"byteOffset\":99,\"bufferView\":0"), says("4 items"));
  EXPECT_THAT(edit("{\"buffer\":0,\"byteLength\":48", "{\"buffer\":1,\"byteLength\":48"),
              says("buffer 1 of 1"));
  EXPECT_THAT(edit("\"byteLength\":48", "\"byteLength\":93"), says("93 bytes from 0 on end after"));
  EXPECT_THAT(edit("\"byteLength\":48", "\"byteStride\":8,\"byteLength\":48"),
              says("a stride of 8 for items of 12"));
  EXPECT_THAT(edit("\"byteLength\":92", "\"byteLength\":9999"), says("[bad-gltf]"));
  EXPECT_THAT(edit("\"byteLength\":92", "\"byteLength\":\"x\""), says("[bad-gltf]"));
  EXPECT_THAT(edit("\"nodes\":[0]", "\"nodes\":[]"), says("[no-triangles]"));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT([&] { parse(kJson, binary().replace(4, 4, raw<float>({nan}))); },
              says("[not-finite]"));
}

TEST(ReadGltf, ContainersThatLieAreRefused) {
  const std::string good = glb(kJson, binary());
  // A binary chunk said to be 8 bytes longer than the file, and one of length 0xFFFFFFFF.
  const std::size_t chunk = good.size() - 8 - 92;
  for (const std::uint32_t length : {96U, 100U, 104U, 0xFFFFFFFFU}) {
    std::string bytes = good;
    bytes.replace(chunk, 4, raw<std::uint32_t>({length}));
    EXPECT_THAT([&] { parse_mesh(bytes, "a.glb"); },
                ThrowsMessage<InvalidInput>(HasSubstr("ends after the file")));
  }
  EXPECT_THAT([&] { parse_mesh(std::string(good).replace(4, 1, "\1"), "a.glb"); },
              ThrowsMessage<InvalidInput>(HasSubstr("version 1 of glTF, not 2")));
}

TEST(ReadGltf, EndlessNestingIsRefused) {
  const std::string deep = std::string(200000, '[') + std::string(200000, ']');
  EXPECT_THROW(parse(with(kJson, "\"scene\":0", "\"extras\":" + deep)), InvalidInput);
}

TEST(ReadGltf, ManyInstancesOfALargeMeshAreRefused) {
  // 65536 triangles by indices of one byte, 1500 times: 98 million triangles of 120 kB.
  std::string nodes, scene;
  for (int i = 0; i < 1500; ++i) {
    nodes += fmt::format("{}{{\"mesh\":0}}", i == 0 ? "" : ",");
    scene += fmt::format("{}{}", i == 0 ? "" : ",", i);
  }
  std::string json = with(kJson, R"({"mesh":0,"name":"floor"})", nodes);
  json = with(json, R"("nodes":[0])", "\"nodes\":[" + scene + "]");
  json = with(json, R"("indices":1)", R"("indices":1,"mode":5)");
  json = with(json, R"("componentType":5123,"count":6)", R"("componentType":5121,"count":65538)");
  json = with(json, R"("byteOffset":48,"byteLength":12)", R"("byteOffset":92,"byteLength":65538)");
  json = with(json, R"("byteLength":92)", R"("byteLength":65630)");
  EXPECT_THAT([&] { parse(json, binary() + std::string(65538, '\0')); },
              ThrowsMessage<InvalidInput>(HasSubstr("[too-large]")));
}

TEST(ReadGltf, ReadsTextWithPartsInsideAndBeside) {
  const tests::TemporaryFolder made("gltf");
  const std::filesystem::path& folder = made.path();
  const std::string text =
      with(kJson, R"({"byteLength":92})", R"({"byteLength":92,"uri":"my%20part.bin"})");
  write_file_atomically(folder / "a.gltf", text);
  EXPECT_THAT([&] { read_mesh(folder / "a.gltf"); },
              ThrowsMessage<InvalidInput>(HasSubstr("my part.bin")));
  write_file_atomically(folder / "my part.bin", binary());
  EXPECT_EQ(read_mesh(folder / "a.gltf").mesh.triangles.size(), 2U);
  std::string wide = "\xFE\xFF";
  for (const char c : text) (wide += '\0') += c;
  write_file_atomically(folder / "a.gltf", wide);
  EXPECT_EQ(read_mesh(folder / "a.gltf").mesh.triangles.size(), 2U) << "UTF-16";
  write_file_atomically(folder / "a.gltf", with(text, "my%20part", "./my%20part"));
  EXPECT_EQ(read_mesh(folder / "a.gltf").mesh.triangles.size(), 2U);
  EXPECT_THROW(parse_mesh(text, "a.gltf"), InvalidInput) << "in memory there is nothing beside";
  // 92 bytes in base64: 30 groups of 3 and one of 2. All zeros but the format's own texts.
  const std::string zeros =
      with(kJson, R"({"byteLength":92})",
           R"({"byteLength":92,"uri":"data:application/octet-stream;base64,)" +
               std::string(123, 'A') + R"(="})");
  EXPECT_THAT(codes(parse_mesh(zeros, "a.gltf")),
              ElementsAre("absurd-size", "degenerate-triangles"));
}

TEST(ReadMesh, RefusesOptionsAndEndings) {
  ReadOptions options;
  for (const double scale : {0.0, -1.0, std::nan("")}) {
    options.scale = scale;
    EXPECT_THROW(parse_mesh("", "a.ply", options), ArgumentError);
  }
  EXPECT_THAT([] { parse_mesh("", "a.stl"); },
              ThrowsMessage<ArgumentError>(HasSubstr("ending \".stl\"")));
  EXPECT_THROW(read_mesh("no/such/file.glb"), FileError);
  EXPECT_THROW(read_mesh("no/such/file.txt"), ArgumentError);
}

TEST(ReadMesh, ReadsTheTavern) {
  const char* data = std::getenv("ENFILADE_DATA");
  if (data == nullptr) GTEST_SKIP() << "ENFILADE_DATA is not set: no mesh that others made";
  const ReadResult r =
      read_mesh(std::filesystem::path(data) / "imagery" / "low_poly_tavern_interior.glb");
  EXPECT_EQ(r.mesh.triangles.size(), 13204U);
  EXPECT_EQ(r.mesh.objects.size(), 52U);
  EXPECT_EQ(r.mesh.materials.size(), 2U);
  EXPECT_EQ(r.mesh.materials[0].texture.width, 512U);
  EXPECT_EQ(r.mesh.texture_points.size(), 13204U);
  const Box box = bounds(r.mesh);
  EXPECT_NEAR(box.high.z - box.low.z, 2.54, 0.01) << "its height, with z up";
  EXPECT_THAT(r.warnings, IsEmpty());
}

}  // namespace EN_UNIT
}  // namespace enfilade::mesh::readers
