/// \file  The old simulator's names, in a module of their own.
#pragma once

namespace nanobind {
class module_;
}

namespace enfilade::python::mattersim {

void bind(nanobind::module_& module);

}  // namespace enfilade::python::mattersim
