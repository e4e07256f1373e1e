// The extension module enfilade._eyes: views of meshes. Separate from _core, because it loads a ray
// tracer.
#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/continuous/eyes.h"
#include "enfilade/core/file.h"
#include "enfilade/homes/built_home.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/mesh/read_mesh.h"
#include "python/src/errors.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace enfilade::python {
namespace {

namespace fs = std::filesystem;
using continuous::Scene;

template <class T>
using Numbers = nb::ndarray<const T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Points = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
template <class T, class Dims>
using Picture = nb::ndarray<T, Dims, nb::c_contig, nb::device::cpu>;
using Rgb = Picture<std::uint8_t, nb::shape<-1, -1, -1, 3>>;
using Depth = Picture<float, nb::ndim<3>>;
using Classes = Picture<std::uint16_t, nb::ndim<3>>;
using Instances = Picture<std::uint32_t, nb::ndim<3>>;

template <class Array>
auto bytes_of(const Array& array) {
  return std::as_writable_bytes(std::span(array.data(), array.size()));
}

/// The renderer of one building.
class BuildingEyes {
 public:
  BuildingEyes(std::shared_ptr<const Scene> scene, int threads)
      : eyes_({std::move(scene)}, {.method = continuous::Method::kRaster, .threads = threads}) {}

  // Draws into arrays of (n, height, width); empty ones are skipped.
  void render(const Points& eyes, const Numbers<double>& headings,
              const Numbers<double>& elevations, std::uint32_t width, std::uint32_t height,
              double vfov, Rgb rgb, Depth depth, Classes classes, Instances instances) {
    const Busy busy(busy_);
    const std::size_t n = eyes.shape(0);
    if (headings.size() != n || elevations.size() != n) {
      throw ArgumentError(fmt::format("{} eyes, {} headings, {} elevations", n, headings.size(),
                                      elevations.size()));
    }
    render::Outputs outputs;
    if (rgb.size() > 0) {
      outputs.colour = render::ColourOutput{render::ColourFormat::kRgb8, {}, bytes_of(rgb)};
    }
    if (depth.size() > 0) {
      outputs.depth = render::DepthOutput{render::DepthFormat::kMetresFloat32,
                                          render::DepthMeasure::kZ, bytes_of(depth)};
    }
    if (classes.size() > 0) {
      outputs.classes = render::ClassOutput{render::ClassFormat::kUint16, bytes_of(classes)};
    }
    if (instances.size() > 0) {
      outputs.instances =
          render::InstanceOutput{std::span<std::uint32_t>(instances.data(), instances.size())};
    }
    const nb::gil_scoped_release unlocked;
    std::vector<continuous::MeshView> views;
    for (std::size_t i = 0; i < n; ++i) {
      views.push_back({0,
                       {eyes(i, 0), eyes(i, 1), eyes(i, 2)},
                       Radians(headings.data()[i]),
                       Radians(elevations.data()[i])});
    }
    eyes_.render({width, height, Radians(vfov)}, views, outputs);
  }
  std::string description() const { return eyes_.description(); }

 private:
  continuous::Eyes eyes_;
  std::atomic_flag busy_ = ATOMIC_FLAG_INIT;
};

// Light from `file`, where an earlier call stored it, or new light, which is then stored there.
std::shared_ptr<const Scene> lit_scene(const homes::BuiltHome& built, const std::string& file,
                                       double spacing, int threads) {
  if (!file.empty() && file_exists(file)) return Scene::load(built.tracer, file);
  continuous::SceneOptions options;
  options.light_spacing = spacing;
  options.threads = threads;
  const mesh::LitMesh light(built.tracer, built.home.lights);
  auto scene = Scene::lit(built.tracer, light, options);
  if (!file.empty()) {
    make_folder(fs::path(file).parent_path());
    scene->save(file);
  }
  return scene;
}

std::unique_ptr<BuildingEyes> of_home(const std::string& data, const std::string& scan,
                                      const std::string& light, double spacing, int threads) {
  const nb::gil_scoped_release unlocked;
  for (const homes::HomeEntry& home : homes::read_home_list(data)) {
    if (home.scan != scan) continue;
    const homes::BuiltHome built = homes::build_home(home.plan);
    return std::make_unique<BuildingEyes>(lit_scene(built, light, spacing, threads), threads);
  }
  throw LookupError(fmt::format("scan \"{}\": no home of {}", scan, data));
}

std::unique_ptr<BuildingEyes> of_mesh(const std::string& file, const std::string& up, int threads) {
  mesh::ReadOptions options;
  if (up == "y") {
    options.up = mesh::UpAxis::kY;
  } else if (up == "z") {
    options.up = mesh::UpAxis::kZ;
  } else if (up != "format") {
    throw ArgumentError(fmt::format("up '{}': one of format, y, z is wanted", up));
  }
  const nb::gil_scoped_release unlocked;
  const auto tracer = std::make_shared<const mesh::RayTracer>(
      std::make_shared<const mesh::Mesh>(mesh::read_mesh(file, options).mesh));
  return std::make_unique<BuildingEyes>(Scene::photographed(tracer), threads);
}

}  // namespace
}  // namespace enfilade::python

namespace enfilade::python {
void bind_habitat(nb::module_& module);  // habitat.cpp
}

NB_MODULE(_eyes, m) {
  using enfilade::python::BuildingEyes;
  enfilade::python::bind_errors();
  nb::class_<BuildingEyes>(m, "BuildingEyes")
      .def("render", &BuildingEyes::render, "eyes"_a, "headings"_a, "elevations"_a, "width"_a,
           "height"_a, "vfov"_a, "rgb"_a, "depth"_a, "classes"_a, "instances"_a)
      .def_prop_ro("description", &BuildingEyes::description);
  m.def("of_home", enfilade::python::of_home, "data"_a, "scan"_a, "light"_a, "spacing"_a,
        "threads"_a);
  m.def("of_mesh", enfilade::python::of_mesh, "file"_a, "up"_a, "threads"_a);
  nb::module_ habitat = m.def_submodule("habitat", "Habitat's floor, bodies and follower.");
  enfilade::python::bind_habitat(habitat);
}
