// The readers of PLY, ASCII and binary of both byte orders.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "enfilade/core/check.h"
#include "enfilade/mesh/read_mesh.h"
#include "enfilade/mesh/semantic_ply.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  try {
    const auto result = mesh::parse_mesh(bytes, "f.ply");
    EN_CHECK_EQ(count(mesh::check(result.mesh, "<read>"), Severity::kError), 0U);
  } catch (const Error&) {
  }
  try {
    const mesh::Mesh labels = mesh::parse_semantic_ply(bytes, "f_semantic.ply");
    EN_CHECK_EQ(count(mesh::check(labels, "<read>"), Severity::kError), 0U);
  } catch (const Error&) {
  }
  return 0;
}
