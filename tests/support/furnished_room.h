/// \file  Two small furnished rooms with a doorway between them, worked out by hand.
#pragma once
#include <string>
#include <vector>

#include "enfilade/capture/scan_files.h"
#include "enfilade/geometry/cube_map.h"
#include "enfilade/mesh/mesh.h"
#include "enfilade/mesh/mesh_builder.h"
#include "enfilade/mesh/mpcat40.h"
#include "enfilade/scan/connectivity.h"

namespace enfilade::tests {

/// A living room, 4 x 5 m, and a bedroom, 3.4 x 5 m, 2.7 m high, with eight things in them and a
/// box on the floor that nobody has labelled.
inline mesh::Mesh furnished_rooms() {
  using C = mesh::Mpcat40;
  mesh::Mesh mesh;
  mesh::MeshBuilder b(mesh);
  const auto paint = [&](float red, float green, float blue) {
    mesh::Material material;
    material.colour = {red, green, blue};
    return b.add_material(material);
  };
  const auto white = paint(.8F, .8F, .75F), wood = paint(.45F, .3F, .18F),
             green = paint(.2F, .5F, .25F), red = paint(.6F, .15F, .12F),
             blue = paint(.2F, .3F, .6F);
  b.box(red, {2.6, 4.2, 0}, {2.9, 4.5, .3});  // of no object
  b.begin_object("floor", C::kFloor, 0);
  b.quad(wood, {0, 0, 0}, {7.5, 0, 0}, {7.5, 5, 0}, {0, 5, 0});
  b.begin_object("ceiling", C::kCeiling, 0);
  b.quad(white, {0, 0, 2.7}, {0, 5, 2.7}, {7.5, 5, 2.7}, {7.5, 0, 2.7});
  b.begin_object("wall", C::kWall, 0);
  b.box(white, {-.1, -.1, 0}, {7.6, 0, 2.7});
  b.box(white, {-.1, 5, 0}, {7.6, 5.1, 2.7});
  b.box(white, {-.1, 0, 0}, {0, 5, 2.7});
  b.box(blue, {7.5, 0, 0}, {7.6, 5, 2.7});
  b.begin_object("wall", C::kWall, 1);  // between the rooms, with a doorway
  b.box(green, {4, 0, 0}, {4.1, 2, 2.7});
  b.box(green, {4, 2.9, 0}, {4.1, 5, 2.7});
  b.box(green, {4, 2, 2.1}, {4.1, 2.9, 2.7});
  b.begin_object("coffee table", C::kTable, 0, {{1.2, 1.4, 0}, .3});
  b.box(wood, {-.6, -.35, .4}, {.6, .35, .45});
  for (const double x : {-.5, .45}) {
    for (const double y : {-.3, .25}) b.box(wood, {x, y, 0}, {x + .05, y + .05, .4});
  }
  b.begin_object("sofa", C::kSofa, 0, {{.5, 3.8, 0}, 0});
  b.soft_box(green, {-.45, -.9, .1}, {.45, .9, .45}, .06);
  b.soft_box(green, {-.45, -.9, .45}, {-.2, .9, .9}, .06);
  b.begin_object("column", C::kColumn, 0);
  b.cylinder(white, {3.2, .8, 0}, .12, .12, 2.7);
  b.begin_object("picture", C::kPicture, 0);
  b.box(red, {2, 4.97, 1.2}, {2.8, 5, 1.8});
  b.begin_object("bed", C::kBed, 1);
  b.soft_box(white, {5.5, .1, .3}, {7.1, 2.1, .55}, .08);
  b.box(wood, {5.5, .1, 0}, {7.1, 2.1, .3});
  b.begin_object("lamp", C::kLighting, 1);
  b.sphere(red, {6.8, 4.5, 1.1}, .18);
  b.bar(wood, {6.8, 4.5, 0}, {6.8, 4.5, .95}, .02);
  b.begin_object("wardrobe", C::kCabinet, 1);
  b.box(wood, {4.1, 4.4, 0}, {5.6, 5, 2.1});
  return mesh;
}

inline std::vector<capture::ScanRoom> furnished_room_list() {
  return {{'l', {0, 0, 4.05, 5}, 0, 2.7, 0}, {'b', {4.05, 0, 7.5, 5}, 0, 2.7, 0}};
}

/// Viewpoints "a" in the living room and "b" in the bedroom, with an edge between them, and "c",
/// which is excluded.
inline scan::Connectivity furnished_room_graph(const std::string& scan = "rooms") {
  scan::Connectivity graph;
  graph.scan = scan;
  const auto add = [&](const std::string& id, double heading, double elevation, Vec3d eye) {
    scan::ConnectivityEntry entry;
    entry.id = id;
    entry.pose = pose_matrix(world_from_camera(degrees(heading), degrees(elevation)), eye);
    entry.height = eye.z;
    graph.entries.push_back(entry);
  };
  add("a", 0, 0, {2.3, 2.6, 1.5});
  add("b", 130, 1, {5.0, 3.1, 1.55});
  add("c", 0, 0, {2, 1, 1.5});
  graph.entries[0].unobstructed = graph.entries[0].visible = {ViewpointIndex(1)};
  graph.entries[1].unobstructed = graph.entries[1].visible = {ViewpointIndex(0)};
  graph.entries[2].included = false;
  return graph;
}

}  // namespace enfilade::tests
