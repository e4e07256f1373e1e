// The readers of house_segmentations: the PLY with its labels, .fsegs.json and .semseg.json; what
// is read, written and read again is equal.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/mesh/segmentation.h"

namespace {

using namespace enfilade;

void read_ply(std::string_view bytes) {
  const mesh::LabelledMesh read = mesh::parse_labelled_ply(bytes, "<fuzz>");
  const mesh::LabelledMesh back =
      mesh::parse_labelled_ply(mesh::to_labelled_ply(read), "<written>");
  EN_CHECK(back.mesh.triangles == read.mesh.triangles);
  EN_CHECK(back.face_segment == read.face_segment);
  EN_CHECK(back.face_object == read.face_object);
  EN_CHECK(back.face_category == read.face_category);
}

template <class F>
void unless_refused(const F& body) {
  try {
    body();
  } catch (const InvalidInput&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  if (bytes.starts_with("ply")) {
    unless_refused([&] { read_ply(bytes); });
    return 0;
  }
  unless_refused([&] {
    const auto read = mesh::parse_face_segments(bytes, "<fuzz>");
    EN_CHECK(mesh::parse_face_segments(mesh::face_segments_json(read, "s"), "<written>") == read);
  });
  unless_refused([&] {
    const auto read = mesh::parse_segment_groups(bytes, "<fuzz>");
    const auto back = mesh::parse_segment_groups(mesh::segment_groups_json(read, "s"), "<written>");
    EN_CHECK_EQ(back.size(), read.size());
    for (std::size_t i = 0; i < read.size(); ++i) EN_CHECK(back[i].label == read[i].label);
  });
  return 0;
}
