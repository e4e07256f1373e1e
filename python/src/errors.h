/// \file  Enfilade's exceptions as Python's.
#pragma once

namespace enfilade::python {

/// Raises Enfilade's C++ exceptions as the classes of enfilade/_errors.py.
/// \throws nb::python_error
void bind_errors();

}  // namespace enfilade::python
