#include "python/src/errors.h"

#include <nanobind/nanobind.h>

#include "enfilade/core/errors.h"

namespace nb = nanobind;

namespace enfilade::python {
namespace {

/// The Python types; they live as long as the process.
struct Types {
  PyObject *error, *argument, *unknown_name, *file, *invalid_input;
};
Types types;

void translate(const std::exception_ptr& p, void*) {
  try {
    std::rethrow_exception(p);
  } catch (const ArgumentError& error) {
    PyErr_SetString(types.argument, error.what());
  } catch (const LookupError& error) {
    PyErr_SetString(types.unknown_name, error.what());
  } catch (const FileError& error) {
    PyErr_SetString(types.file, error.what());
  } catch (const InvalidInput& error) {
    PyErr_SetString(types.invalid_input, error.what());
  } catch (const WrongOrder& error) {
    PyErr_SetString(PyExc_RuntimeError, error.what());
  } catch (const Error& error) {
    PyErr_SetString(types.error, error.what());
  }
}

}  // namespace

void bind_errors() {
  const nb::module_ m = nb::module_::import_("enfilade._errors");
  const auto type = [&](const char* name) { return nb::object(m.attr(name)).release().ptr(); };
  types = {type("Error"), type("ArgumentError"), type("UnknownNameError"), type("FileError"),
           type("InvalidInput")};
  nb::register_exception_translator(translate);
}

}  // namespace enfilade::python
