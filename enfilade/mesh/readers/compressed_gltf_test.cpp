// Files that gltf-transform 4 has packed, by its commands `draco`, `meshopt` and `webp`.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cstdint>
#include <filesystem>

#include "enfilade/core/file.h"
#include "enfilade/mesh/read_mesh.h"
#include "enfilade/mesh/readers/gltf.h"
#include "enfilade/mesh/readers/reader.h"
#include "enfilade/mesh/readers/webp.h"
#include "tests/support/photo_files.h"

namespace enfilade::mesh::readers {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

std::filesystem::path vector_file(const char* name) {
  return std::filesystem::path(EN_SOURCE_DIR) / "tests" / "fuzz" / "seeds" / "mesh_gltf" / name;
}

/// The lattice of 5 x 5 vertices that the files hold: z is up here, and rows have one colour each.
void expect_lattice(const ReadResult& r, double tolerance) {
  EXPECT_EQ(r.mesh.triangles.size(), 32U);
  const Box box = bounds(r.mesh);
  EXPECT_NEAR(box.low.x, -2, tolerance);
  EXPECT_NEAR(box.high.x, 2, tolerance);
  EXPECT_NEAR(box.high.y, 2, tolerance);
  EXPECT_NEAR(box.high.z, 0.5, tolerance);
  ASSERT_EQ(r.mesh.normals.size(), 32U);
  ASSERT_EQ(r.mesh.texture_points.size(), 32U);
  for (std::size_t t = 0; t < 32; ++t) {
    EXPECT_GT(r.mesh.normals[t][0].z, 0.8);
    for (std::size_t k = 0; k < 3; ++k) {  // u follows x
      const float x = r.mesh.positions[r.mesh.triangles[t][k]].x;
      EXPECT_NEAR(r.mesh.texture_points[t][k].u, (x + 2) / 4, 0.01);
    }
  }
}

struct Packed {
  const char* file;
  std::string_view extension;
  double tolerance;  ///< of positions, metres: quantised to 14 bits (Draco: 11) over 4 m
};

TEST(ReadGltf, ReadsPackedGeometry) {
  for (const Packed& packed :
       {Packed{"lattice.glb", "", 1e-6}, Packed{"lattice_draco.glb", kDracoCompression, 0.002},
        Packed{"lattice_meshopt.glb", kMeshoptCompression, 0.0005}}) {
    SCOPED_TRACE(packed.file);
    if (packed.extension.empty() || reads_extension(packed.extension)) {
      const ReadResult r = read_mesh(vector_file(packed.file));
      expect_lattice(r, packed.tolerance);
      EXPECT_TRUE(r.warnings.empty()) << to_string(r.warnings.front());
    } else {
      EXPECT_THAT([&] { read_mesh(vector_file(packed.file)); },
                  ThrowsMessage<InvalidInput>(HasSubstr("this build is without")));
    }
  }
}

TEST(ReadGltf, ReadsWebpTextures) {
  const ReadResult r = read_mesh(vector_file("lattice_webp.glb"));
  expect_lattice(r, 1e-6);
  ASSERT_EQ(r.mesh.materials.size(), 1U);
  if (!reads_extension(kWebpTexture)) {
    ASSERT_EQ(r.warnings.size(), 1U);
    EXPECT_THAT(r.warnings[0].message, HasSubstr("this build is without libwebp"));
    return;
  }
  EXPECT_TRUE(r.warnings.empty());
  const image::Image8& texture = r.mesh.materials[0].texture;
  ASSERT_EQ(texture.width, 8U);
  EXPECT_GT(texture.at(0, 0)[0], 200) << "the left half is red";
  EXPECT_LT(texture.at(0, 0)[1], 60);
  EXPECT_GT(texture.at(7, 0)[1], 200) << "the right half is green";
}

/// The chunk of a RIFF file.
std::string chunk(const std::string& name, std::string_view content) {
  std::string out = name;
  for (int k = 0; k < 4; ++k) out += static_cast<char>(content.size() >> (8 * k) & 0xFFU);
  return out.append(content).append(content.size() % 2, '\0');
}

/// The lattice's WebP picture of 8 x 8 pixels, with EXIF data.
std::string webp_with(const std::string& exif) {
  const std::string glb = read_file(vector_file("lattice_webp.glb"));
  const std::string simple = glb.substr(glb.find("RIFF") + 12, 82);  // its chunk "VP8 "
  const std::string head("\x08\0\0\0\x07\0\0\x07\0\0", 10);          // EXIF; sides less one
  return chunk("RIFF", "WEBP" + chunk("VP8X", head) + simple + chunk("EXIF", exif));
}

TEST(ReadGltf, WebpTexturesAreTurnedByExif) {
  if (!reads_webp()) GTEST_SKIP() << "built without libwebp";
  const std::string exif = tests::exif(6);
  for (const std::string& data : {exif, exif.substr(6)}) {  // "Exif" and two zeros before it
    ReadResult r;
    const image::Image8 texture = TextureDecoder().decode(webp_with(data), "a.webp", r);
    ASSERT_EQ(texture.width, 8U);
    EXPECT_GT(texture.at(7, 0)[0], 200) << "the stored left is at the top";
    EXPECT_GT(texture.at(0, 7)[1], 200);
    ASSERT_EQ(r.warnings.size(), 1U);
    EXPECT_EQ(r.warnings[0].message, "EXIF orientation 6: turned by a quarter clockwise");
  }
}

TEST(ReadGltf, WebpTexturesAreReducedWhileTheyAreRead) {
  if (!reads_webp()) GTEST_SKIP() << "built without libwebp";
  const std::string lossy = webp_with("");
  const image::Image8 whole = decode_webp(lossy, "a.webp", 64);
  const image::Image8 half = decode_webp(lossy, "a.webp", 63);
  ASSERT_EQ(half.width, 4U);
  const image::Image8 wanted = image::shrink(whole, 4, 4);
  // The whole picture's colours are smoothed across edges, those of the reduced one are not.
  for (std::size_t k = 0; k < wanted.pixels.size(); ++k) {
    EXPECT_NEAR(half.pixels[k], wanted.pixels[k], 48) << k;
  }
  const std::string lossless(  // 4 x 2 pixels of 200, 10, 30
      "RIFF\x1e\0\0\0WEBPVP8L\x11\0\0\0\x2f\3\x40\0\0\7\x50\x85\x22\xd7\xa3\xff\x81\x88\xe8\x7f\0"
      "\0",
      38);
  EXPECT_EQ(decode_webp(lossless, "a.webp", 8).at(3, 1)[0], 200);
  EXPECT_THAT([&] { decode_webp(lossless, "a.webp", 7); },
              ThrowsMessage<InvalidInput>(HasSubstr("a lossless WebP picture of 4 x 2 pixels")));
}

TEST(ReadGltf, ExifOfWebpMayBeCutOff) {
  const std::string whole = webp_with(tests::exif(6));
  for (std::size_t n = 12; n < whole.size(); ++n) {
    EXPECT_LE(webp_exif(std::string_view(whole).substr(0, n)).size(), tests::exif(6).size()) << n;
  }
  EXPECT_EQ(webp_exif(whole), tests::exif(6));
}

/// A .glb with a part of its JSON replaced.
std::string edited(std::string_view glb, std::string_view old, const std::string& fresh) {
  std::string json(gltf_json_chunk(glb, "a.glb"));
  const std::string_view rest = glb.substr(20 + json.size());
  const std::size_t at = json.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  json.replace(at, old.size(), fresh);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const auto word = [](std::size_t n) {
    const auto value = static_cast<std::uint32_t>(n);
    return std::string(reinterpret_cast<const char*>(&value), sizeof value);
  };
  return "glTF" + word(2) + word(20 + json.size() + rest.size()) + word(json.size()) + "JSON" +
         json + std::string(rest);
}

TEST(ReadGltf, ViewsThatUnpackTooMuchAreRefused) {
  if (!reads_extension(kMeshoptCompression)) GTEST_SKIP() << "built without meshoptimizer";
  const std::string good = read_file(vector_file("lattice_meshopt.glb"));
  const auto counted = [&](const char* count) {  // 126 bytes: at most 31 items, and 64
    const std::string fresh = std::string(R"("byteStride":256,"count":)") + count;
    return edited(good, R"("byteStride":8,"count":25)", fresh);
  };
  EXPECT_THAT([&] { parse_mesh(counted("95"), "a.glb"); },
              ThrowsMessage<InvalidInput>(HasSubstr("its data are damaged")));
  EXPECT_THAT([&] { parse_mesh(counted("96"), "a.glb"); },
              ThrowsMessage<InvalidInput>(HasSubstr("96 items of 256 bytes, from 126 bytes")));
  const auto repeated = [&](int times) {  // 200 bytes each time
    std::string views;
    for (int k = 0; k < times; ++k) {
      views += R"(,{"buffer":1,"byteLength":200,"extensions":{"EXT_meshopt_compression":{"buffer":0,
          "byteOffset":224,"byteLength":126,"mode":"ATTRIBUTES","byteStride":8,"count":25}}})";
    }
    return edited(good, R"(],"samplers")", views + R"(],"samplers")");
  };
  EXPECT_EQ(parse_mesh(repeated(5000), "a.glb").mesh.triangles.size(), 32U);
  EXPECT_THAT([&] { parse_mesh(repeated(6000), "a.glb"); },
              ThrowsMessage<InvalidInput>(HasSubstr("[too-large]")));
}

TEST(ReadGltf, DamagedPackedGeometryIsRefusedOrReadInside) {
  for (const char* name : {"lattice_draco.glb", "lattice_meshopt.glb", "lattice_webp.glb"}) {
    const std::string good = read_file(vector_file(name));
    // Each byte behind the JSON in turn; its own allocation, so that a sanitizer sees its end.
    const std::size_t begin = good.size() - std::min<std::size_t>(good.size() / 2, 700);
    for (std::size_t at = begin; at < good.size(); ++at) {
      std::string bytes = good;
      bytes[at] = static_cast<char>(bytes[at] ^ 0x5A);
      try {
        const ReadResult r = parse_mesh(bytes, "a.glb");
        EXPECT_EQ(count(check(r.mesh, "a.glb"), Severity::kError), 0U);
      } catch (const InvalidInput&) {
      }
    }
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::mesh::readers
