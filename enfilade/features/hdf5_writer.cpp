#include "enfilade/features/hdf5_writer.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"
#include "enfilade/core/part_file.h"
#include "enfilade/features/formats/hdf5_datasets.h"

namespace enfilade::features {
namespace {

using formats::Hdf5Handle;
using formats::Hdf5Library;

// A pack is read and unpacked as one: about a megabyte is quick for both.
constexpr std::uint64_t kChunkBytes = std::uint64_t{1} << 20U;

Hdf5Handle stored_type(Hdf5Type type) {
  if (type == Hdf5Type::kFloat16) return formats::half_type();
  const std::array<hid_t, 5> others{H5T_IEEE_F32LE, H5T_IEEE_F64LE, H5T_STD_U8LE, H5T_STD_U16LE,
                                    H5T_STD_I64LE};
  return {H5Tcopy(others.at(static_cast<std::size_t>(type) - 1)), H5Tclose};
}

Hdf5Handle text_type(std::size_t size = H5T_VARIABLE) {
  Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.id(), size);
  H5Tset_cset(type.id(), H5T_CSET_UTF8);
  return type;
}

Hdf5Handle simple_space(const std::vector<hsize_t>& shape) {
  return {H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose};
}

std::vector<hsize_t> sizes_of(const Hdf5Array& array) {
  return {array.shape.begin(), array.shape.end()};
}

void check_array(const std::string& name, const Hdf5Array& array) {
  std::uint64_t bytes = size_of(array.type);
  for (const std::uint64_t size : array.shape) {
    if (size == 0 || size > array.bytes.size() || bytes > array.bytes.size()) {
      bytes = 0;
      break;
    }
    bytes *= size;
  }
  if (array.shape.empty() || bytes != array.bytes.size()) {
    throw ArgumentError(fmt::format("{}: an array of {} bytes does not have the shape that is said",
                                    name, array.bytes.size()));
  }
}

void check_text(const std::string& name, const std::string& text) {
  if (text.find('\0') != std::string::npos) {
    throw ArgumentError(fmt::format("{}: a text with a null character", name));
  }
}

}  // namespace

std::size_t size_of(Hdf5Type type) noexcept {
  constexpr std::array<std::size_t, 6> kSizes{2, 4, 8, 1, 2, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

struct Hdf5Writer::Impl {
  Impl(const std::filesystem::path& target, const Hdf5Options& options)
      : file(target), gzip(options.gzip), replaces(options.replaces) {
    check_range("gzip", gzip, 0, 9);
    part = PartFile(file).path();  // PartFile throws if it cannot be written
    const Hdf5Library library;
    Hdf5Handle made(H5Fcreate(part.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
    check(made.good());
    for (const auto& [name, text] : options.texts) write_fixed_text(made.id(), name, text);
    handle = std::move(made);
  }
  ~Impl() {
    const Hdf5Library library;
    handle.close();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void check(bool done) const {
    if (done) return;
    throw FileError(fmt::format("{}: cannot be written: {}", part.string(), Hdf5Library::reason()));
  }

  /// Makes way for a name.
  void clear_name(const std::string& name) const {
    check_text("a name", name);
    if (name.empty() || name.find('/') != std::string::npos) {
      throw ArgumentError(
          fmt::format("{}: not a name of an array in the root group", quote(name, 100)));
    }
    if (H5Lexists(handle.id(), name.c_str(), H5P_DEFAULT) > 0) {
      if (replaces) return check(H5Ldelete(handle.id(), name.c_str(), H5P_DEFAULT) >= 0);
      throw ArgumentError(fmt::format("{}: {} is there already", part.string(), quote(name, 100)));
    }
  }

  /// How a packed array is stored. \pre gzip > 0
  Hdf5Handle layout_of(const Hdf5Array& array) const {
    Hdf5Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    // Whole sub-arrays along the first axis, as many as make a pack.
    std::vector<hsize_t> chunk = sizes_of(array);
    const std::uint64_t row = array.bytes.size() / chunk[0];
    chunk[0] = std::clamp<hsize_t>(kChunkBytes / std::max<std::uint64_t>(row, 1), 1, chunk[0]);
    check(H5Pset_chunk(layout.id(), static_cast<int>(chunk.size()), chunk.data()) >= 0 &&
          H5Pset_deflate(layout.id(), static_cast<unsigned>(gzip)) >= 0);
    return layout;
  }

  void write_value(hid_t to, const char* name, const Hdf5Handle& type, const Hdf5Handle& space,
                   const void* value) const {
    const Hdf5Handle attribute(
        H5Acreate2(to, name, type.id(), space.id(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    check(attribute.good() && H5Awrite(attribute.id(), type.id(), value) >= 0);
  }

  void write_fixed_text(hid_t to, const std::string& name, const std::string& text) const {
    if (text.empty()) return;
    const Hdf5Handle type = text_type(text.size());
    const Hdf5Handle scalar(H5Screate(H5S_SCALAR), H5Sclose);
    check(H5Tset_strpad(type.id(), H5T_STR_NULLPAD) >= 0);
    write_value(to, name.c_str(), type, scalar, text.data());
  }

  void write_attribute(hid_t to, const Hdf5Attribute& attribute) const {
    const char* const name = attribute.name.c_str();
    const Hdf5Handle scalar(H5Screate(H5S_SCALAR), H5Sclose);
    if (const auto* text = std::get_if<std::string>(&attribute.value)) {
      const char* const start = text->c_str();
      write_value(to, name, text_type(), scalar, &start);
    } else if (const auto* integer = std::get_if<std::int64_t>(&attribute.value)) {
      write_value(to, name, stored_type(Hdf5Type::kInt64), scalar, integer);
    } else if (const auto* real = std::get_if<double>(&attribute.value)) {
      write_value(to, name, stored_type(Hdf5Type::kFloat64), scalar, real);
    } else if (const auto* texts = std::get_if<std::vector<std::string>>(&attribute.value)) {
      std::vector<const char*> starts;
      for (const std::string& one : *texts) starts.push_back(one.c_str());
      write_value(to, name, text_type(), simple_space({texts->size()}), starts.data());
    } else {
      const auto& array = std::get<Hdf5Array>(attribute.value);
      write_value(to, name, stored_type(array.type), simple_space(sizes_of(array)),
                  array.bytes.data());
    }
  }

  std::filesystem::path file, part;
  int gzip;
  bool replaces;
  Hdf5Handle handle{-1, H5Fclose};
};

namespace {

void check_values(const Hdf5Dataset& dataset) {
  check_array(dataset.name, dataset.array);
  for (const Hdf5Attribute& attribute : dataset.attributes) {
    const std::string name = dataset.name + "." + attribute.name;
    check_text(name, attribute.name);
    if (const auto* array = std::get_if<Hdf5Array>(&attribute.value)) check_array(name, *array);
    if (const auto* text = std::get_if<std::string>(&attribute.value)) check_text(name, *text);
    if (const auto* texts = std::get_if<std::vector<std::string>>(&attribute.value)) {
      if (texts->empty()) throw ArgumentError(fmt::format("{}: no texts", name));
      for (const std::string& text : *texts) check_text(name, text);
    }
  }
}

}  // namespace

Hdf5Writer::Hdf5Writer(const std::filesystem::path& file, const Hdf5Options& options)
    : impl_(std::make_unique<Impl>(file, options)) {}
Hdf5Writer::~Hdf5Writer() = default;
Hdf5Writer::Hdf5Writer(Hdf5Writer&&) noexcept = default;
Hdf5Writer& Hdf5Writer::operator=(Hdf5Writer&&) noexcept = default;

void Hdf5Writer::write(const Hdf5Dataset& dataset) {
  check_values(dataset);
  const Hdf5Library library;
  impl_->clear_name(dataset.name);
  const Hdf5Handle type = stored_type(dataset.array.type);
  const Hdf5Handle space = simple_space(sizes_of(dataset.array));
  const Hdf5Handle layout =
      impl_->gzip == 0 ? Hdf5Handle(-1, H5Pclose) : impl_->layout_of(dataset.array);
  const Hdf5Handle made(
      H5Dcreate2(impl_->handle.id(), dataset.name.c_str(), type.id(), space.id(), H5P_DEFAULT,
                 layout.good() ? layout.id() : H5P_DEFAULT, H5P_DEFAULT),
      H5Dclose);
  impl_->check(made.good());
  impl_->check(H5Dwrite(made.id(), type.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT,
                        dataset.array.bytes.data()) >= 0);
  for (const Hdf5Attribute& attribute : dataset.attributes) {
    impl_->write_attribute(made.id(), attribute);
  }
}

void Hdf5Writer::copy_from(const std::filesystem::path& file) {
  const Hdf5Library library;
  const Hdf5Handle from(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!from.good()) {
    throw FileError(fmt::format("{}: cannot be read: {}", file.string(), Hdf5Library::reason()));
  }
  const formats::Hdf5Links links = formats::links_of(from.id());
  if (!links.read || !links.hard) {
    throw FileError(fmt::format("{}: cannot be read: {}", file.string(), Hdf5Library::reason()));
  }
  for (const std::string& name : links.names) {
    impl_->clear_name(name);
    impl_->check(H5Ocopy(from.id(), name.c_str(), impl_->handle.id(), name.c_str(), H5P_DEFAULT,
                         H5P_DEFAULT) >= 0);
  }
}

void Hdf5Writer::finish() {
  {
    const Hdf5Library library;
    impl_->check(H5Fflush(impl_->handle.id(), H5F_SCOPE_LOCAL) >= 0);
    impl_->check(impl_->handle.close());
  }
  PartFile(impl_->file).finish();
}

}  // namespace enfilade::features
