/// \file  Conversion of arguments of old code: ints, NumPy scalars, lists, tuples, arrays. Accepts
/// what the old binding accepted; everything else is a TypeError (thrown as nb::python_error).
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "python/src/mattersim/types.h"

namespace enfilade::python::mattersim {

/// A text, not a list of texts. bytes count as text.
bool is_text(PyObject* o);
bool is_list(PyObject* o);  ///< a sequence other than a text

std::string to_text(PyObject* o, const char* name);
bool to_flag(PyObject* o, const char* name);  ///< a number or another object with __bool__; None
double to_angle(PyObject* o, const char* name);
/// Integers of any type, and arrays of one; no floats.
std::int64_t to_index(PyObject* o, const char* name);
std::int64_t to_integer(PyObject* o, const char* name, std::int64_t least, std::int64_t most);

std::vector<std::string> to_texts(PyObject* o, const char* name);
/// The first `count` elements; `out` is reused, so that a step allocates nothing.
/// IndexError for a shorter list, or one that an element's methods shorten meanwhile.
void to_angles(PyObject* o, const char* name, std::size_t count, std::vector<double>& out);
/// A TypeError for negative ones, as in the old binding.
void to_indices(PyObject* o, const char* name, std::size_t count, std::vector<std::int64_t>& out);

/// IndexError. \pre found < wanted
[[noreturn]] void too_short(const char* name, std::size_t found, std::size_t wanted);

}  // namespace enfilade::python::mattersim
