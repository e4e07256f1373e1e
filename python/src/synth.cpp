// The extension module enfilade._synth: synthetic homes. Separate from _core: it loads a ray
// tracer.
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <optional>
#include <string>

#include "enfilade/homes/home_set.h"
#include "python/src/errors.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace enfilade::python {
namespace {

nb::tuple write_homes(const std::string& folder, const std::string& preset, std::size_t homes,
                      std::uint64_t seed, std::optional<std::uint32_t> face_size, int threads) {
  homes::HomePathReport paths;
  std::size_t made = 0;
  {
    const nb::gil_scoped_release unlocked;
    homes::HomeSetOptions options = homes::home_set_preset(preset);
    if (homes > 0) options.homes = homes;
    options.seed = seed;
    if (face_size) options.face_size = *face_size;
    options.threads = threads;
    made = homes::write_homes(folder, options).homes.size();
    homes::HomePathOptions path_options;
    path_options.threads = threads;
    if (made >= homes::kLeastHomes) paths = homes::write_home_paths(folder, path_options);
  }
  return nb::make_tuple(made, paths.paths, paths.instructions);
}

}  // namespace
}  // namespace enfilade::python

NB_MODULE(_synth, m) {
  enfilade::python::bind_errors();
  m.def("write_homes", enfilade::python::write_homes, "folder"_a, "preset"_a, "homes"_a, "seed"_a,
        "face_size"_a.none(), "threads"_a,
        nb::sig("def write_homes(folder: str, preset: str, homes: int, seed: int, "
                "face_size: int | None, threads: int) -> tuple[int, int, int]"));
}
