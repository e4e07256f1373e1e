#include "enfilade/features/formats/hdf5_datasets.h"

#include <fmt/format.h>
#include <algorithm>
#include <cstdint>
#include <exception>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/features/formats/feature_rows.h"

namespace enfilade::features::formats {
namespace {

// More numbers than any viewpoint has; a small file must not make us allocate more.
constexpr std::uint64_t kMostElements = std::uint64_t{1} << 24;

Hdf5Handle open_file(const std::filesystem::path& path, const std::string& name) {
  Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!file.good()) {
    refuse(name, "", "bad-hdf5", "not an HDF5 file, or a damaged one: " + Hdf5Library::reason());
  }
  return file;
}

struct Links {
  std::vector<std::string> names;
  bool hard = true;
};

}  // namespace

bool is_plain_float(hid_t type) {
  const Hdf5Handle half = half_type();
  const std::array<hid_t, 5> plain{half.id(), H5T_IEEE_F32LE, H5T_IEEE_F32BE, H5T_IEEE_F64LE,
                                   H5T_IEEE_F64BE};
  return std::ranges::any_of(plain, [&](hid_t one) { return H5Tequal(type, one) > 0; });
}

bool is_plain_number(hid_t type) {
  const std::array<hid_t, 6> plain{H5T_STD_I32LE, H5T_STD_I64LE, H5T_STD_I16LE,
                                   H5T_STD_U32LE, H5T_STD_U64LE, H5T_STD_U16LE};
  return is_plain_float(type) ||
         std::ranges::any_of(plain, [&](hid_t one) { return H5Tequal(type, one) > 0; });
}

Hdf5Source::Hdf5Source(const std::filesystem::path& path, std::string name)
    : name_(std::move(name)), file_(open_file(path, name_)) {}

void Hdf5Source::fail(const std::string& dataset, const char* code, std::string message) const {
  refuse(name_, in_quotes(dataset), code, std::move(message));
}

void Hdf5Source::fail_damaged(const std::string& dataset) const {
  fail(dataset, "bad-hdf5", "cannot be read: " + Hdf5Library::reason());
}

std::vector<std::string> Hdf5Source::datasets() const {
  Links links;
  const herr_t result = H5Literate(
      file_.id(), H5_INDEX_NAME, H5_ITER_INC, nullptr,
      [](hid_t, const char* name, const H5L_info_t* info, void* into) -> herr_t {
        auto& found = *static_cast<Links*>(into);
        try {
          found.names.emplace_back(name);
        } catch (const std::exception&) {
          return -1;  // nothing may be thrown through the library
        }
        found.hard = info->type == H5L_TYPE_HARD;
        return found.hard ? 0 : 1;
      },
      &links);
  if (!links.hard) {
    fail(links.names.back(), "foreign-link", "a soft or external link; only datasets are read");
  }
  if (result < 0) {
    refuse(name_, "", "bad-hdf5", "its list of datasets cannot be read: " + Hdf5Library::reason());
  }
  return std::move(links.names);
}

Hdf5Handle Hdf5Source::open_dataset(const std::string& dataset) const {
  Hdf5Handle opened(H5Dopen2(file_.id(), dataset.c_str(), H5P_DEFAULT), H5Dclose);
  if (!opened.good()) fail_damaged(dataset);
  return opened;
}

void Hdf5Source::check_size(const std::string& dataset, const std::array<hsize_t, 2>& size) const {
  if (size[0] == 0 || size[1] == 0 || size[0] > kMostElements ||
      size[1] > kMostElements / size[0]) {
    fail(dataset, "bad-shape",
         fmt::format("{} x {} numbers, not 1 to {}", size[0], size[1], kMostElements));
  }
}

std::array<hsize_t, 2> Hdf5Source::size_of(const std::string& dataset,
                                           const Hdf5Handle& opened) const {
  const Hdf5Handle space(H5Dget_space(opened.id()), H5Sclose);
  if (!space.good()) fail_damaged(dataset);
  std::array<hsize_t, 2> size{};
  if (H5Sget_simple_extent_ndims(space.id()) != 2 ||
      H5Sget_simple_extent_dims(space.id(), size.data(), nullptr) != 2) {
    fail(dataset, "bad-shape", "not an array of views and dimensions");
  }
  check_size(dataset, size);
  return size;
}

void Hdf5Source::check_layout(const std::string& dataset, const Hdf5Handle& opened) const {
  if (H5Dget_storage_size(opened.id()) == 0) fail(dataset, "no-data", "a dataset without data");
  const Hdf5Handle made(H5Dget_create_plist(opened.id()), H5Pclose);
  const H5D_layout_t layout = H5Pget_layout(made.id());
  if (layout == H5D_VIRTUAL || H5Pget_external_count(made.id()) != 0) {
    fail(dataset, "foreign-link", "its data is in other files; only data in this file is read");
  }
  if (layout != H5D_CHUNKED) return;
  std::array<hsize_t, 2> chunk{};
  if (H5Pget_chunk(made.id(), 2, chunk.data()) != 2) fail_damaged(dataset);
  check_size(dataset, chunk);
}

std::shared_ptr<const MappedFile> read_isolated(const std::filesystem::path& file,
                                                const std::function<void(SharedMemory&)>& copy) {
  const MappedFile readable(file);  // throws the system's reason, which the library does not give
  SharedMemory memory(file.string());
  {
    const Hdf5Library library;
    run_isolated(file.string(), "bad-hdf5", [&] { copy(memory); });
  }
  return std::make_shared<const MappedFile>(memory.path());
}

}  // namespace enfilade::features::formats
