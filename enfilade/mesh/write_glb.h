/// \file  Binary glTF in memory; write_glb() of read_mesh.h writes the same into a file.
#pragma once
#include <string>

#include "enfilade/mesh/mesh.h"

namespace enfilade::mesh {

/// The bytes of the file that write_glb() writes. \throws ArgumentError if they are more than 4 GiB
std::string to_glb(const Mesh& mesh);

}  // namespace enfilade::mesh
