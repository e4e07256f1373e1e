// DatasetFolder: a data folder.
#include "enfilade/dataset/dataset.h"

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/objects.h"
#include "python/src/bindings.h"

namespace enfilade::python {
namespace {

using dataset::Dataset;
using namespace nb::literals;

Dataset open_dataset(const std::optional<std::filesystem::path>& folder) {
  if (folder) return Dataset(*folder);
  if (auto named = Dataset::from_environment()) return *std::move(named);
  throw FileError("no folder was named, and the environment variable ENFILADE_DATA is not set");
}

// (name, present, what was found or why not, how to get it)
nb::list examine(const Dataset& dataset) {
  std::vector<dataset::Part> parts;
  {
    const nb::gil_scoped_release unlocked;
    parts = dataset.examine();
  }
  nb::list rows;
  for (const dataset::Part& part : parts) {
    rows.append(nb::make_tuple(part.name, part.present, part.found, part.advice));
  }
  return rows;
}

// {benchmark: its splits in the folder}
nb::dict splits_by_task(const Dataset& dataset) {
  nb::dict found;
  for (const tasks::Benchmark* one : dataset.benchmarks()) {
    found[nb::str(one->name.data(), one->name.size())] = dataset.splits(*one);
  }
  return found;
}

// [(id, name, views, boxes), ...]
nb::list objects_at(const Dataset& dataset, const std::string& scan, const std::string& viewpoint) {
  const tasks::ObjectBoxes* objects = nullptr;
  {
    const nb::gil_scoped_release unlocked;
    objects = &dataset.objects();
  }
  nb::list found;
  for (const tasks::ViewedObject& object : objects->at(scan, viewpoint)) {
    nb::list views, boxes;
    for (const std::uint8_t view : object.views) views.append(view);
    for (const auto& b : object.boxes) boxes.append(nb::make_tuple(b[0], b[1], b[2], b[3]));
    found.append(nb::make_tuple(object.id, object.name, nb::tuple(views), nb::tuple(boxes)));
  }
  return found;
}

}  // namespace

void bind_dataset(nb::module_& m) {
  nb::class_<Dataset>(m, "DatasetFolder", "The core of enfilade.Dataset.")
      .def(nb::new_(&open_dataset), "folder"_a.none())
      .def_prop_ro("folder", &Dataset::folder)
      .def_prop_ro("synthetic", &Dataset::synthetic)
      .def_prop_ro("splits",
                   [](const Dataset& d) { return d.splits(tasks::benchmark(tasks::Task::kR2r)); })
      .def_prop_ro("graphs", [](const Dataset& d) { return d.graphs(); })
      .def_prop_ro("panoramas", [](const Dataset& d) { return d.panoramas(); })
      .def_prop_ro("panorama_places",
                   [](const Dataset& d) {
                     const scan::PanoramaPlaces places = d.panorama_places();
                     return std::pair(places.images, places.connectivity);
                   })
      .def(
          "region",
          [](const Dataset& d, const std::string& scan, const std::string& viewpoint) {
            return d.regions().find(scan, viewpoint);
          },
          "scan"_a, "viewpoint"_a)
      .def_prop_ro("tasks", splits_by_task, nb::sig("def tasks(self) -> dict[str, list[str]]"))
      .def("objects_at", objects_at, "scan"_a, "viewpoint"_a,
           nb::sig("def objects_at(self, scan: str, viewpoint: str) -> list[tuple[int, str, "
                   "tuple[int, ...], tuple[tuple[int, int, int, int], ...]]]"))
      .def("examine", examine, nb::sig("def examine(self) -> list[tuple[str, bool, str, str]]"));
}

}  // namespace enfilade::python
