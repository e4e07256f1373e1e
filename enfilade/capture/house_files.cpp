#include "enfilade/capture/scan_files.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/image/tone.h"
#include "enfilade/mesh/mpcat40.h"
#include "enfilade/scan/matterport_cameras.h"

namespace enfilade::capture {
namespace {

using mesh::HouseBox;
using mesh::kMpcat40Size;
using mesh::Mesh;
using mesh::mpcat40;

Vec3d middle(const HouseBox& box) { return 0.5 * (box.low + box.high); }

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr HouseBox kNothing{{kInfinity, kInfinity, kInfinity},
                            {-kInfinity, -kInfinity, -kInfinity}};

void include(HouseBox& box, Vec3d p) {
  box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
  box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
}

/// Files cannot hold infinity: an empty box becomes a point.
HouseBox finite(const HouseBox& box) { return box.low.x <= box.high.x ? box : HouseBox{}; }

// --- pieces ---------------------------------------------------------------------------------

class Union {
 public:
  explicit Union(std::size_t size) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), 0U);
  }
  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) { parent_[root(a)] = root(b); }

 private:
  std::vector<std::uint32_t> parent_;
};

/// The connected piece of each triangle: corners at one place join triangles of one object.
std::vector<std::int32_t> pieces(const Mesh& mesh) {
  const std::size_t n = mesh.triangles.size();
  const auto key = [&mesh](std::uint32_t corner) {
    const Vec3f p = mesh.positions[mesh.triangles[corner / 3][corner % 3]];
    return std::tuple(object_of(mesh, corner / 3), p.x, p.y, p.z);
  };
  std::vector<std::uint32_t> order(3 * n), place(3 * n);  // of corners
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::sort(order, std::less<>(), key);
  std::uint32_t last = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (k > 0 && key(order[k]) != key(order[k - 1])) ++last;
    place[order[k]] = last;
  }
  Union joined(std::size_t{last} + 1);
  for (std::size_t t = 0; t < n; ++t) {
    joined.join(place[3 * t + 1], place[3 * t]);
    joined.join(place[3 * t + 2], place[3 * t]);
  }
  std::vector<std::int32_t> of_root(std::size_t{last} + 1, -1), result(n);
  std::int32_t next = 0;
  for (std::size_t t = 0; t < n; ++t) {
    std::int32_t& piece = of_root[joined.root(place[3 * t])];
    if (piece < 0) piece = next++;
    result[t] = piece;
  }
  return result;
}

// --- colours --------------------------------------------------------------------------------

float linear(std::uint8_t srgb) { return image::linear_from_srgb(static_cast<float>(srgb) / 255); }

/// The mean colour of a material, without light.
Vec3f mean_colour(const mesh::Material& material) {
  const image::Image8& texture = material.texture;
  const std::size_t pixels = std::size_t{texture.width} * texture.height;
  if (pixels == 0) return material.colour;
  // A few thousand pixels are enough; an odd step visits different columns of the texture.
  const std::size_t step = pixels < 4096 ? 1 : pixels / 4096 | 1U;
  Vec3f sum;
  std::size_t count = 0;
  for (std::size_t i = 0; i < pixels; i += step, ++count) {
    const std::uint8_t* p = texture.pixels.data() + i * texture.channels;
    sum += Vec3f{linear(p[0]), linear(p[1]), linear(p[2])};
  }
  const float scale = 1 / static_cast<float>(count);
  return {sum.x * scale * material.colour.x, sum.y * scale * material.colour.y,
          sum.z * scale * material.colour.z};
}

std::vector<Vec3f> vertex_colours(const Mesh& mesh) {
  std::vector<Vec3f> of_material, sum(mesh.positions.size());
  for (const mesh::Material& material : mesh.materials) {
    of_material.push_back(mean_colour(material));
  }
  std::vector<float> count(mesh.positions.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t v : mesh.triangles[t]) {
      sum[v] += of_material[mesh.triangle_material[t]];
      count[v] += 1;
    }
  }
  for (std::size_t v = 0; v < sum.size(); ++v) {
    const Vec3f own = mesh.colours.empty() ? Vec3f{1, 1, 1} : mesh.colours[v];
    const float k = 1 / std::max(count[v], 1.F);
    sum[v] = {sum[v].x * k * own.x, sum[v].y * k * own.y, sum[v].z * k * own.z};
  }
  return sum;
}

// --- the house ------------------------------------------------------------------------------

std::int32_t region_below(const std::vector<ScanRoom>& rooms, Vec3d p) {
  const auto room = std::ranges::find_if(rooms, [&](const ScanRoom& r) {
    return r.floor.contains(p.x, p.y) && p.z >= r.floor_z && p.z <= r.floor_z + r.height;
  });
  return room == rooms.end() ? -1 : static_cast<std::int32_t>(room - rooms.begin());
}

class HouseMaker {
 public:
  HouseMaker(const Mesh& mesh, const scan::Connectivity& connectivity,
             const std::vector<ScanRoom>& rooms, std::uint32_t image_width)
      : mesh_(mesh), connectivity_(connectivity), rooms_(rooms), image_width_(image_width) {
    for (const auto& corners : mesh.triangles) {
      for (const std::uint32_t v : corners) include(house_.box, to_double(mesh.positions[v]));
    }
    one_room_ = rooms.empty();
    if (one_room_) {  // the whole building
      const auto& [low, high] = house_.box;
      rooms_.push_back({'z', {low.x, low.y, high.x, high.y}, low.z, high.z - low.z, 0});
    }
    house_.name = connectivity.scan;
  }

  HouseFiles make() {
    HouseFiles files;
    files.segments = pieces(mesh_);
    add_rooms();
    add_panoramas();
    add_categories();
    add_objects();
    add_segments(files.segments);
    files.groups = groups();
    files.labels = labels(files.segments);
    files.house = std::move(house_);
    return files;
  }

 private:
  void add_rooms() {
    for (std::size_t k = 0; k < rooms_.size(); ++k) {
      const ScanRoom& room = rooms_[k];
      const HouseBox box{{room.floor.x0, room.floor.y0, room.floor_z},
                         {room.floor.x1, room.floor.y1, room.floor_z + room.height}};
      const Vec3d at{middle(box).x, middle(box).y, room.floor_z};
      while (house_.levels.size() <= room.storey) house_.levels.push_back({"", {}, kNothing});
      include(house_.levels[room.storey].box, box.low);
      include(house_.levels[room.storey].box, box.high);
      house_.regions.push_back(
          {static_cast<std::int32_t>(room.storey), room.type, at, box, room.height});
      const auto surface = static_cast<std::int32_t>(k);
      constexpr Vec3d kUp{0, 0, 1};
      const Vec3d flat{box.high.x, box.high.y, box.low.z};
      house_.surfaces.push_back({surface, 'F', at, kUp, {box.low, flat}});
      for (const Vec3d corner :
           {box.low, Vec3d{flat.x, box.low.y, flat.z}, flat, Vec3d{box.low.x, flat.y, flat.z}}) {
        house_.vertices.push_back({surface, "", corner, kUp});
      }
    }
    for (mesh::HouseLevel& level : house_.levels) {
      level.box = finite(level.box);
      level.position = middle(level.box);
    }
  }

  void add_panoramas() {
    for (const scan::PanoramaPose& pose : poses_of(connectivity_)) {
      if (!pose.included) continue;
      const auto place = static_cast<std::int32_t>(house_.panoramas.size());
      const auto cameras = scan::rig_cameras(pose, image_width_);
      // As in Matterport3D's files, the panorama's position is that of its first image.
      house_.panoramas.push_back(
          {pose.viewpoint, region_below(rooms_, pose.position), cameras[0].position});
      for (const scan::RigCamera& camera : cameras) add_image(place, camera);
    }
  }

  void add_image(std::int32_t panorama, const scan::RigCamera& c) {
    mesh::HouseImage image;
    image.panorama = panorama;
    image.name = c.viewpoint;
    image.camera = static_cast<std::int32_t>(c.camera);
    image.yaw = static_cast<std::int32_t>(c.yaw);
    const Mat3d r = transpose(scan::with_y_up(c.world_from_camera));
    image.camera_from_world = pose_matrix(r, -(r * c.position));
    image.intrinsics = {c.fx, 0, c.cx, 0, c.fy, c.height - 1 - c.cy, 0, 0, 1};
    image.width = c.width;
    image.height = c.height;
    image.position = c.position;
    house_.images.push_back(std::move(image));
  }

  /// Adds a category for each class of an object; class 0 has none.
  void add_categories() {
    category_.fill(-1);
    for (const mesh::Object& object : mesh_.objects) {
      if (object.category >= kMpcat40Size) {
        throw ArgumentError(fmt::format("object {:?}: category {}, not one of mpcat40's 0 to {}",
                                        object.name, object.category, kMpcat40Size - 1));
      }
      category_[object.category] = 0;
    }
    category_[0] = -1;
    for (std::size_t k = 0; k < kMpcat40Size; ++k) {
      if (category_[k] < 0) continue;
      category_[k] = static_cast<std::int32_t>(house_.categories.size());
      house_.categories.push_back({mpcat40(k).row, std::string(mpcat40(k).raw),
                                   static_cast<std::int32_t>(k), std::string(mpcat40(k).name)});
    }
  }

  void add_objects() {
    std::vector<HouseBox> boxes(mesh_.objects.size(), kNothing);
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      const std::uint32_t object = object_of(mesh_, t);
      if (object == mesh::kNoObject) continue;
      for (const std::uint32_t v : mesh_.triangles[t]) {
        include(boxes[object], to_double(mesh_.positions[v]));
      }
    }
    for (std::size_t k = 0; k < boxes.size(); ++k) {
      const mesh::Object& object = mesh_.objects[k];
      const HouseBox box = finite(boxes[k]);
      const bool known =
          object.region >= 0 && static_cast<std::size_t>(object.region) < rooms_.size();
      const std::int32_t region = one_room_ ? 0 : known ? object.region : -1;
      house_.objects.push_back({region,
                                category_[object.category],
                                middle(box),
                                {1, 0, 0},
                                {0, 1, 0},
                                box.high - middle(box)});
    }
  }

  void add_segments(const std::vector<std::int32_t>& of_triangle) {
    for (std::size_t t = 0; t < of_triangle.size(); ++t) {
      const auto segment = static_cast<std::size_t>(of_triangle[t]);
      if (segment == house_.segments.size()) {
        const std::uint32_t object = object_of(mesh_, t);
        house_.segments.push_back(
            {object == mesh::kNoObject ? -1 : static_cast<std::int32_t>(object),
             of_triangle[t],
             0,
             {},
             kNothing});
      }
      mesh::HouseSegment& s = house_.segments[segment];
      const auto& corners = mesh_.triangles[t];
      const Vec3d a = to_double(mesh_.positions[corners[0]]),
                  b = to_double(mesh_.positions[corners[1]]) - a,
                  c = to_double(mesh_.positions[corners[2]]) - a;
      s.area += length(cross(b, c)) / 2;
      for (const std::uint32_t v : corners) include(s.box, to_double(mesh_.positions[v]));
    }
    for (mesh::HouseSegment& s : house_.segments) s.position = middle(s.box);
  }

  std::vector<mesh::SegmentGroup> groups() const {
    std::vector<mesh::SegmentGroup> result(mesh_.objects.size());
    for (std::size_t k = 0; k < result.size(); ++k) {
      result[k].id = static_cast<std::int32_t>(k);
      result[k].label = mesh_.objects[k].name;
    }
    for (const mesh::HouseSegment& segment : house_.segments) {
      if (segment.object < 0) continue;
      result[static_cast<std::size_t>(segment.object)].segments.push_back(segment.id);
    }
    std::erase_if(result, [](const mesh::SegmentGroup& group) { return group.segments.empty(); });
    return result;
  }

  mesh::LabelledMesh labels(const std::vector<std::int32_t>& segments) const {
    mesh::LabelledMesh labels;
    labels.mesh.positions = mesh_.positions;
    labels.mesh.triangles = mesh_.triangles;
    labels.mesh.triangle_material.assign(mesh_.triangles.size(), 0);
    labels.mesh.materials.emplace_back();
    labels.mesh.materials[0].colour = {1, 1, 1};
    labels.mesh.colours = vertex_colours(mesh_);
    labels.face_segment = segments;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      const std::uint32_t object = object_of(mesh_, t);
      const bool known = object != mesh::kNoObject;
      const std::size_t category = known ? mesh_.objects[object].category : 0;
      labels.face_object.push_back(known ? static_cast<std::int32_t>(object) : -1);
      labels.face_category.push_back(category == 0 ? -1 : mpcat40(category).row);
      labels.face.push_back(static_cast<std::uint32_t>(t));
    }
    return labels;
  }

  const Mesh& mesh_;
  const scan::Connectivity& connectivity_;
  std::vector<ScanRoom> rooms_;
  std::uint32_t image_width_;
  bool one_room_ = false;
  mesh::House house_{"", "", kNothing, {}, {}, {}, {}, {}, {}, {}, {}, {}, {}};
  std::array<std::int32_t, kMpcat40Size> category_{};  // of the house, by class; -1: none
};

}  // namespace

HouseFiles make_house_files(const Mesh& mesh, const scan::Connectivity& connectivity,
                            const std::vector<ScanRoom>& rooms, std::uint32_t image_width) {
  return HouseMaker(mesh, connectivity, rooms, image_width).make();
}

}  // namespace enfilade::capture
