#include "enfilade/dataset/mesh_files.h"

#include <gtest/gtest.h>

#include "enfilade/core/file.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::dataset {
namespace EN_UNIT {

namespace fs = std::filesystem;

class MeshFiles : public ::testing::Test {
 protected:
  void write(const fs::path& file) const {
    make_folder((made_.path() / file).parent_path());
    write_file_atomically(made_.path() / file, "");
  }
  // Where it is below the folder of the test; empty if there is none.
  static std::string place(const std::optional<MeshFile>& found, const fs::path& below) {
    return found ? found->file.lexically_relative(below).string() : "";
  }
  std::string found(const std::string& scan) const {
    return place(find_mesh_file(made_.path(), scan), made_.path());
  }
  std::string found_in(const fs::path& folder, const std::string& scan) const {
    return place(find_mesh_in(made_.path() / folder, scan), made_.path());
  }
  const tests::TemporaryFolder made_{"mesh_files"};
};

constexpr const char* kScan = "00800-TEEsavR23oF";

TEST_F(MeshFiles, OfHm3dAreFoundInTheFoldersOfItsSplits) {
  for (const fs::path above : {"", "scene_datasets", "data/scene_datasets"}) {
    for (const char* folder : {"hm3d/train", "hm3d/val", "hm3d/minival", "hm3d", "hm3d_v0.2/val"}) {
      const fs::path file = above / folder / kScan / "TEEsavR23oF.basis.glb";
      write(file);
      EXPECT_EQ(found(kScan), file);
      EXPECT_EQ(find_mesh_file(made_.path(), kScan)->up, mesh::UpAxis::kZ);
      fs::remove(made_.path() / file);
    }
  }
  write("data/versioned_data/hm3d-0.2/hm3d/val/00800-TEEsavR23oF/TEEsavR23oF.basis.glb");
  EXPECT_NE(found(kScan), "");
  EXPECT_EQ(found("00801-TEEsavR23oF"), "");
  EXPECT_EQ(found("TEEsavR23oF"), "");
  EXPECT_EQ(found("00800-"), "");
}

// Its textures are pictures that every reader has.
TEST_F(MeshFiles, APlainGlbCountsBeforeOneWithBasisTextures) {
  write("hm3d/val/00800-TEEsavR23oF/TEEsavR23oF.basis.glb");
  write("hm3d/val/00800-TEEsavR23oF/TEEsavR23oF.semantic.glb");
  EXPECT_EQ(found(kScan), "hm3d/val/00800-TEEsavR23oF/TEEsavR23oF.basis.glb");
  write("hm3d/val/00800-TEEsavR23oF/TEEsavR23oF.glb");
  EXPECT_EQ(found(kScan), "hm3d/val/00800-TEEsavR23oF/TEEsavR23oF.glb");
}

TEST_F(MeshFiles, AFolderOfMeshesMayBeHm3dOrASplitOfIt) {
  const std::string file = "some/val/00800-TEEsavR23oF/TEEsavR23oF.basis.glb";
  write(file);
  for (const char* folder : {"some", "some/val"}) {
    EXPECT_EQ(found_in(folder, kScan), file);
    EXPECT_EQ(find_mesh_in(made_.path() / folder, kScan)->up, mesh::UpAxis::kZ);
  }
  EXPECT_EQ(found_in("some/train", kScan), "");
  write("some/00800-TEEsavR23oF.glb");
  EXPECT_EQ(found_in("some", kScan), "some/00800-TEEsavR23oF.glb");
  EXPECT_EQ(find_mesh_in(made_.path() / "some", kScan)->up, mesh::UpAxis::kFormat);
}

TEST_F(MeshFiles, AScansOwnFolderIsEnough) {
  const fs::path folder = made_.path() / "hm3d/val" / kScan,
                 file = folder / "TEEsavR23oF.basis.glb";
  write(file);
  write("mp3d/one/one.glb");
  EXPECT_EQ(find_mesh_in(folder, kScan)->file, file);
  EXPECT_EQ(find_mesh_in(folder, "00801-TEEsavR23oF"), std::nullopt);
  for (const fs::path& path : {folder, folder / "", folder / ".", file}) {
    EXPECT_EQ(mesh_at(path).file, file);
    EXPECT_EQ(mesh_at(path).up, mesh::UpAxis::kZ) << path;
  }
  EXPECT_EQ(mesh_at(made_.path() / "mp3d/one").file, made_.path() / "mp3d/one/one.glb");
  for (const fs::path& path :
       {folder / "TEEsavR23oF.semantic.glb", made_.path() / "mp3d/one/one.glb", made_.path()}) {
    EXPECT_EQ(mesh_at(path).file, path);
    EXPECT_EQ(mesh_at(path).up, mesh::UpAxis::kFormat) << path;
  }
}

TEST_F(MeshFiles, OfOtherDataSetsAreFoundAsBefore) {
  write("mp3d/one/one.glb");
  EXPECT_EQ(found("one"), "mp3d/one/one.glb");
  EXPECT_EQ(find_mesh_file(made_.path(), "one")->up, mesh::UpAxis::kZ);
  write("v1/scans/two/matterport_mesh/abc/abc.obj");
  EXPECT_EQ(found("two"), "v1/scans/two/matterport_mesh/abc/abc.obj");
  write("meshes/three.basis.glb");
  EXPECT_EQ(found("three"), "meshes/three.basis.glb");
  write("meshes/three.ply");
  EXPECT_EQ(found("three"), "meshes/three.ply");
  EXPECT_EQ(find_mesh_file(made_.path(), "three")->up, mesh::UpAxis::kFormat);
}

}  // namespace EN_UNIT
}  // namespace enfilade::dataset
