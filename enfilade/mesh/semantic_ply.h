/// \file  Labels of Habitat's copies of Matterport3D: SCAN_semantic.ply, the object of each face.
#pragma once
#include <string>
#include <string_view>

#include "enfilade/mesh/mesh.h"

namespace enfilade::mesh {

/// The mesh of such a file, with the file's axes, one material and no colours. Object k has the
/// `object_id` k + 1, and faces of id 0 have none: instances in pictures are the ids.
///
/// As Habitat-Sim reads it: vertices have colours, ids are integers of any type, and 16 bits of
/// them are kept, so that an `int` of -1 is 65535.
/// \throws InvalidInput for a broken file, missing properties, ids above 65535, and errors of
/// check()
Mesh parse_semantic_ply(std::string_view bytes, const std::string& file);

}  // namespace enfilade::mesh
