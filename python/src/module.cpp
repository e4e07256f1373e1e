// The extension module enfilade._core.
#include <nanobind/nanobind.h>

#include "python/src/bindings.h"
#include "python/src/errors.h"

namespace nb = nanobind;

NB_MODULE(_core, m) {
  nb::set_leak_warnings(false);  // objects in caches of the process are not leaks
  using namespace enfilade::python;
  bind_errors();
  for (const auto bind :
       {bind_features, bind_graphs, bind_simulator, bind_renderer, bind_dataset, bind_episodes,
        bind_scores, bind_environment, bind_arena, bind_continuous, bind_continuous_episodes}) {
    bind(m);
  }
  nb::module_ mattersim = m.def_submodule("mattersim", "The old simulator's interface.");
  mattersim::bind(mattersim);
}
