/// \file  Sensors of Habitat-Sim: pictures as it draws them, at any pose.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

#include "enfilade/continuous/habitat/body.h"
#include "enfilade/continuous/habitat/nav_mesh.h"
#include "enfilade/continuous/scene.h"
#include "enfilade/geometry/angle.h"

namespace enfilade::continuous::habitat {

/// How a sensor maps directions to pixels.
enum class Lens : std::uint8_t {
  kPinhole,
  kEquirectangular,  ///< looked up in a cube map; the middle column is where the sensor looks
  kFisheye,          ///< likewise: the double sphere model
};
constexpr std::array<std::string_view, 3> names_of(Lens /*enum*/) {
  return {"pinhole", "equirectangular", "fisheye"};
}

/// The double sphere model of a fisheye lens.
struct DoubleSphere {
  double focal_x = 0, focal_y = 0;    ///< pixels, > 0
  double middle_x = 0, middle_y = 0;  ///< pixels from the left and the top edge, of the axis
  double xi = -0.18;
  double alpha = 0.59;  ///< [0, 1]
  friend bool operator==(const DoubleSphere&, const DoubleSphere&) = default;
};

/// What a sensor draws. Defaults are Habitat's. A plain value.
struct Sensor {
  Lens lens = Lens::kPinhole;
  std::uint32_t width = 128, height = 128;         ///< pixels, 1 .. 8192
  Radians horizontal_field_of_view = degrees(90);  ///< of pinholes, in (0, pi)
  DoubleSphere double_sphere{};                    ///< of fisheyes
  /// Edge of the cube's faces, pixels, up to 8192; 0: the shorter edge of the picture.
  std::uint32_t cube_size = 0;
  /// Surfaces nearer or farther than these are not drawn. Metres along the axis of the sensor or
  /// the cube's face; 0 < near < far.
  float near = 0.01F, far = 1000;
  friend bool operator==(const Sensor&, const Sensor&) = default;
};

/// \throws ArgumentError naming the field, its value and the range
void check(const Sensor& sensor);

/// Memory for one picture, rows from the top. An empty span: not asked for.
struct SensorPicture {
  std::span<std::uint8_t> colour;     ///< (height, width, 4), R G B A; A = 255
  std::span<float> depth;             ///< metres along the axis of the sensor or the cube's face
  std::span<std::uint32_t> instance;  ///< object k of the mesh is k + 1; 0: none
};

/// A mesh file as Habitat shows it: display values, no light.
/// \throws as mesh::read_mesh(), mesh::RayTracer
std::shared_ptr<const Scene> open_scene(const std::filesystem::path& file, Upright up);
/// A file of labels, SCAN_semantic.ply, as Habitat shows it to semantic sensors: instances are its
/// `object_id`s. Habitat turns its vertices by the frame of the stage, and then from z up to y up.
/// \param frame  of the stage, or what its `semantic_up` says. With kY, +z is up in the file. With
/// kZ, both turns are made, and -y is up.
/// \throws FileError; as mesh::parse_semantic_ply(), mesh::RayTracer
std::shared_ptr<const Scene> open_labels(const std::filesystem::path& file, Upright frame);

/// Draws what sensors see. Depth is 0 and colour black where there is no surface. Equirectangular
/// pictures and fisheyes take depth and instance from the nearest texel of the cube's face, and
/// colour between four. One thread at a time; several objects may share a scene.
class Sensors {
 public:
  /// \param threads  0: all cores; does not change the pictures
  /// \throws ArgumentError for a null scene or threads below 0
  explicit Sensors(std::shared_ptr<const Scene> scene, int threads = 0);
  ~Sensors();
  Sensors(const Sensors&) = delete;
  Sensors& operator=(const Sensors&) = delete;

  /// Fills the picture. \param pose  of the sensor in the world, Habitat's frame: in_world().
  /// Allocates nothing after the first call with the sensor, as Eyes::render().
  /// \throws ArgumentError for a sensor or pose out of range, or memory of another size
  void render(const Sensor& sensor, const Pose& pose, const SensorPicture& picture);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::continuous::habitat
