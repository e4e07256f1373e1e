#include "enfilade/features/tensor_file.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>

#include "enfilade/core/errors.h"
#include "enfilade/core/mapped_file.h"
#include "enfilade/core/part_file.h"
#include "enfilade/features/formats/stored_arrays.h"

namespace enfilade::features {

std::size_t size_of(DType type) noexcept {
  constexpr std::array<std::size_t, 9> kSizes{2, 2, 4, 8, 4, 8, 1, 8, 1};
  return kSizes[static_cast<std::size_t>(type)];
}

std::string_view to_string(DType type) noexcept {
  constexpr std::array<std::string_view, 9> kNames{"F16", "BF16", "F32", "F64", "I32",
                                                   "I64", "U8",   "U64", "BOOL"};
  return kNames[static_cast<std::size_t>(type)];
}

std::size_t NamedArray::elements() const noexcept {
  std::size_t product = 1;
  for (const std::int64_t side : shape) product *= static_cast<std::size_t>(side);
  return product;
}

struct TensorFile::Impl {
  explicit Impl(const std::filesystem::path& file) : path(file), map(file) {
    const auto bytes = std::as_bytes(map.bytes());
    const std::string name = file.string();
    if (formats::looks_like_zip(bytes)) {
      stored = formats::is_npz(file) ? formats::read_npz(file) : formats::read_torch_zip(file);
    } else if (formats::looks_like_pickle(bytes)) {
      stored = formats::read_torch_pickle(bytes, name);
    } else {
      stored = formats::read_safetensors(bytes, name);
    }
    std::ranges::sort(stored.arrays, {}, &NamedArray::name);
  }

  std::filesystem::path path;
  MappedFile map;
  formats::StoredArrays stored;
};

TensorFile TensorFile::open(const std::filesystem::path& file) {
  TensorFile opened;
  opened.impl_ = std::make_shared<const Impl>(file);
  return opened;
}

std::span<const NamedArray> TensorFile::arrays() const noexcept { return impl_->stored.arrays; }

const NamedArray* TensorFile::find(std::string_view name) const noexcept {
  const auto& arrays = impl_->stored.arrays;
  const auto found = std::ranges::lower_bound(
      arrays, name, {}, [](const NamedArray& array) { return std::string_view(array.name); });
  return found != arrays.end() && found->name == name ? &*found : nullptr;
}

const std::map<std::string, std::string>& TensorFile::metadata() const noexcept {
  return impl_->stored.metadata;
}

const std::filesystem::path& TensorFile::path() const noexcept { return impl_->path; }

void write_safetensors(const std::filesystem::path& file, std::span<const NamedArray> arrays,
                       const std::map<std::string, std::string>& metadata) {
  const formats::SafetensorsLayout layout = formats::lay_out_safetensors(arrays, metadata);
  for (const NamedArray& array : arrays) {
    const std::size_t bytes = *formats::bytes_of_shape(array.shape, array.type);
    if (array.bytes.size() != bytes) {
      throw ArgumentError(fmt::format("array {:?}: {} bytes, not the {} of its shape", array.name,
                                      array.bytes.size(), bytes));
    }
  }
  PartFile part(file);
  try {
    part.resize(0);
    part.write_at(0, std::as_bytes(std::span(layout.start)));
    for (std::size_t i = 0; i < arrays.size(); ++i) {
      part.write_at(layout.offsets[i], arrays[i].bytes);
    }
    part.finish();
  } catch (...) {
    part.remove();
    throw;
  }
}

}  // namespace enfilade::features
