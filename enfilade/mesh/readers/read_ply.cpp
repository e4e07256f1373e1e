#include <fmt/format.h>

#include "enfilade/mesh/readers/ply.h"
#include "enfilade/mesh/readers/reader.h"

namespace enfilade::mesh::readers {

ReadResult read_ply(const Source& source) {
  const ply::File file = ply::parse(source.bytes, source.name, ply::geometry_properties());
  ply::Geometry geometry = ply::geometry(file, source.name);
  ReadResult out;
  out.mesh = std::move(geometry.mesh);
  for (const ply::Element& element : file.elements) {
    if (element.name == "vertex" || element.name == "face" || element.rows == 0) continue;
    warn(out, source, "element " + element.name, "left-out",
         fmt::format("{} rows are not read: only vertex and face are", element.rows));
  }
  if (geometry.short_faces > 0) {
    warn(out, source, "element face", "left-out",
         fmt::format("{} faces of fewer than 3 corners", geometry.short_faces));
  }
  return out;
}

}  // namespace enfilade::mesh::readers
