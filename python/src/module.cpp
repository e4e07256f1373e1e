// The extension module enfilade._core.
#include <nanobind/nanobind.h>

#include "python/src/bindings.h"
#include "python/src/errors.h"

namespace nb = nanobind;

NB_MODULE(_core, m) {
  nb::set_leak_warnings(false);  // objects in caches of the process are not leaks
  enfilade::python::bind_errors();
  enfilade::python::bind_features(m);
  enfilade::python::bind_graphs(m);
  enfilade::python::bind_simulator(m);
  enfilade::python::bind_renderer(m);
  enfilade::python::bind_gl_trial(m);
  enfilade::python::bind_dataset(m);
  enfilade::python::bind_episodes(m);
  enfilade::python::bind_scores(m);
  enfilade::python::bind_tokens(m);
  enfilade::python::bind_environment(m);
  enfilade::python::bind_arena(m);
  enfilade::python::bind_continuous(m);
  enfilade::python::bind_continuous_episodes(m);
  nb::module_ mattersim = m.def_submodule("mattersim", "The old simulator's interface.");
  enfilade::python::mattersim::bind(mattersim);
}
