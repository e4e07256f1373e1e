/// \file  Wavefront's material files. Internal.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/mesh/readers/reader.h"

namespace enfilade::mesh::readers {

/// A material and the names of its textures, which are not read yet.
struct MtlMaterial {
  Material material;
  std::string colour_map, alpha_map;
};
/// Invalid lines give warnings, as a mesh without a colour can still be used.
/// \param file in messages
std::vector<MtlMaterial> parse_mtl(std::string_view text, const std::string& file,
                                   std::vector<Diagnostic>& warnings);

}  // namespace enfilade::mesh::readers
