// Files of named arrays: features as safetensors.
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/features/tensor_file.h"
#include "python/src/bindings.h"

namespace enfilade::python {
namespace {

using features::DType;
using features::NamedArray;
using features::TensorFile;
using namespace nb::literals;
using AnyArray = nb::ndarray<nb::numpy, nb::ro>;
using Arrays = std::map<std::string, nb::ndarray<nb::ro, nb::c_contig, nb::device::cpu>>;

const NamedArray& array_named(const TensorFile& file, const std::string& name) {
  const NamedArray* const array = file.find(name);
  if (array == nullptr) {
    throw LookupError(fmt::format("{}: no array {:?}", file.path().string(), name));
  }
  return *array;
}

std::optional<nb::dlpack::dtype> float_type(DType type) {
  if (type == DType::kFloat32) return nb::dtype<float>();
  if (type == DType::kFloat16) return kHalf;
  return std::nullopt;
}

// A view of the file's memory, which `self` keeps alive.
AnyArray array_view(nb::handle_t<TensorFile> self, const std::string& name) {
  const auto& file = nb::cast<const TensorFile&>(self);
  const NamedArray& array = array_named(file, name);
  const auto type = float_type(array.type);
  if (!type) {
    throw InvalidInput(
        {{Severity::kError, file.path().string(), name, "wrong-type",
          fmt::format("numbers of type {}, not F32 or F16", enum_name(array.type))}});
  }
  const std::vector<std::size_t> shape(array.shape.begin(), array.shape.end());
  return {array.bytes.data(), shape.size(), shape.data(), self, nullptr, *type};
}

void write(const std::filesystem::path& path, const Arrays& arrays,
           const std::map<std::string, std::string>& metadata) {
  std::vector<NamedArray> named;
  for (const auto& [name, values] : arrays) {
    const DType type = values.dtype() == nb::dtype<float>() ? DType::kFloat32 : DType::kFloat16;
    if (values.dtype() != float_type(type)) {
      throw ArgumentError(fmt::format("array {:?}: neither float32 nor float16", name));
    }
    named.push_back(
        {name, type, {}, {static_cast<const std::byte*>(values.data()), values.nbytes()}});
    for (std::size_t i = 0; i < values.ndim(); ++i) {
      named.back().shape.push_back(static_cast<std::int64_t>(values.shape(i)));
    }
  }
  const nb::gil_scoped_release unlocked;
  features::write_safetensors(path, named, metadata);
}

}  // namespace

void bind_features(nb::module_& module) {
  nb::class_<TensorFile>(module, "TensorFile", "The arrays of a file of weights or features.")
      .def(
          "__init__",
          [](TensorFile* self, const std::filesystem::path& path) {
            const nb::gil_scoped_release unlocked;
            new (self) TensorFile(TensorFile::open(path));
          },
          "file"_a)
      .def("names",
           [](const TensorFile& self) {
             std::vector<std::string> names;
             for (const NamedArray& array : self.arrays()) names.push_back(array.name);
             return names;
           })
      .def("metadata", &TensorFile::metadata)
      .def("array", array_view, "name"_a,
           "A read-only view of an array of float32 or float16, (*shape).");
  module.def("write_safetensors", write, "file"_a, "arrays"_a, "metadata"_a,
             "Writes arrays of float32 or float16 by their names.");
}

}  // namespace enfilade::python
