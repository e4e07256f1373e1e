/// \file  Buildings as scenes that Habitat-Sim opens, in the folders that Habitat's programs
/// expect.
#pragma once
#include <string>
#include <string_view>

#include "enfilade/capture/scan_files.h"
#include "enfilade/continuous/habitat_scene_floor.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/mesh/mesh.h"
#include "enfilade/mesh/segmentation.h"

namespace enfilade::exports {

/// A file of a scene, relative to the folder that habitat-lab calls `data`:
/// "scene_datasets/mp3d/SCAN/SCAN.glb" for the ending ".glb".
std::string habitat_scene_file(std::string_view scan, std::string_view ending);

/// The `_semantic.ply` of Habitat's copies of Matterport3D: the mesh, z up, with the number of each
/// face's object in the .house file. Faces of no object have 0, which Habitat reads where nothing
/// is, too. Binary, little-endian.
/// \pre labels.face_object has one number for each triangle
/// \throws ArgumentError for an object beyond 65535
std::string to_semantic_ply(const mesh::LabelledMesh& labels);

/// Writes a scene:
/// - `SCAN.glb`, +z up in the file: Habitat takes every .glb that is opened by its path to be so
/// - `SCAN.house` and `SCAN_semantic.ply`: what the semantic scene is made of
/// - `SCAN.navmesh`: its floor, for a body of Habitat's default size
///
/// A .navmesh beside the same .glb is kept, as it takes seconds to make; a killed call can be
/// repeated.
/// \param data  what habitat-lab calls `data`  \param house  of the same mesh
/// \returns the floor in SCAN.navmesh
/// \throws FileError; InvalidInput for a mesh without floor, or a broken .navmesh there
continuous::HabitatSceneFloor write_habitat_scene(const OutputFolder& data, const std::string& scan,
                                                  const mesh::Mesh& mesh,
                                                  const capture::HouseFiles& house);

/// Writes `scene_datasets/mp3d/mp3d.scene_dataset_config.json`. By it Habitat finds the scenes by
/// their names, and knows that z is up. It also brings the labels to where the mesh is.
/// Habitat-Sim since v0.2.2 does not do that for a scene that is opened by its path.
/// \throws FileError
void write_habitat_dataset(const OutputFolder& data);

}  // namespace enfilade::exports
