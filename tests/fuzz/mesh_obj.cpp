// The reader of OBJ, and that of its materials: the same bytes once as either.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "enfilade/core/check.h"
#include "enfilade/core/file.h"
#include "enfilade/mesh/read_mesh.h"
#include "tests/support/temporary_folder.h"

namespace {

using namespace enfilade;

/// A folder of an OBJ that names a material file.
class Folder {
 public:
  Folder() {
    write_file_atomically(
        made_.path() / "f.obj",
        "mtllib f.mtl\nv 0 0 0\nv 2 0 0\nv 0 2 0\nvt 0 0\nusemtl oak\nf 1/1 2 3\n");
  }
  const std::filesystem::path& path() const { return made_.path(); }

 private:
  const tests::TemporaryFolder made_{"fuzz_obj"};
};

void expect_usable(const mesh::ReadResult& result) {
  EN_CHECK_EQ(count(mesh::check(result.mesh, "<read>"), Severity::kError), 0U);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Folder kFolder;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  write_file_atomically(kFolder.path() / "f.mtl", text);
  expect_usable(mesh::read_mesh(kFolder.path() / "f.obj"));  // materials are never refused
  try {
    expect_usable(mesh::parse_mesh(text, "f.obj"));
  } catch (const InvalidInput&) {
  }
  return 0;
}
