#include "enfilade/features/tensor_file.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/gzip.h"
#include "enfilade/core/mapped_file.h"
#include "enfilade/core/names.h"
#include "enfilade/core/part_file.h"
#include "enfilade/features/formats/stored_arrays.h"
#include "enfilade/scan/file_tree.h"
#include "enfilade/scan/npy.h"

namespace enfilade::features {
namespace {

// --- NumPy's `.npz`, a zip archive with a `.npy` per array ---

constexpr std::string_view kEnding = ".npy";

std::optional<DType> type_of(const scan::NpyArray& array) {
  constexpr std::array<std::pair<std::string_view, DType>, 8> kTypes{{{"f2", DType::kFloat16},
                                                                      {"f4", DType::kFloat32},
                                                                      {"f8", DType::kFloat64},
                                                                      {"i4", DType::kInt32},
                                                                      {"i8", DType::kInt64},
                                                                      {"u1", DType::kUint8},
                                                                      {"u8", DType::kUint64},
                                                                      {"b1", DType::kBool}}};
  const std::string_view type = std::string_view(array.type()).substr(1);  // without its byte order
  const auto found = std::ranges::find(kTypes, type, &std::pair<std::string_view, DType>::first);
  return found == kTypes.end() ? std::nullopt : std::optional(found->second);
}

class UnsupportedType : public Error {
 public:
  using Error::Error;
};

void read_array(const scan::FileTree& zip, const std::string& entry, formats::StoredArrays& into) {
  const auto array = scan::NpyArray::parse(zip.read(entry).value());
  const auto type = type_of(array);
  if (!type) {
    throw UnsupportedType(fmt::format(
        "elements of type {}; f2, f4, f8, i4, i8, u1, u8 and b1 are read", quote(array.type())));
  }
  const auto to = into.allocate(array.size() * array.item_bytes());
  array.copy_elements(to);
  NamedArray& named = into.arrays.emplace_back();
  named.name = entry.substr(0, entry.size() - kEnding.size());
  named.type = *type;
  for (const std::size_t side : array.shape()) {
    named.shape.push_back(static_cast<std::int64_t>(side));
  }
  named.bytes = to;
}

// Whether a zip archive has only `.npy` files, as `.npz` do. \throws FileError, InvalidInput
bool is_npz(const std::filesystem::path& file) {
  const auto names = scan::FileTree::zip(file, scan::ZipNames::kPaths)->names();
  return !names.empty() && std::ranges::all_of(names, [](const std::string& name) {
    return name.ends_with(kEnding);
  });
}

// Names are the paths in the archive without ".npy". Arrays of another type are left out.
// \throws FileError; InvalidInput naming each array that is damaged, or all if none can be read
formats::StoredArrays read_npz(const std::filesystem::path& file) {
  const auto zip = scan::FileTree::zip(file, scan::ZipNames::kPaths);
  formats::StoredArrays read;
  std::vector<Diagnostic> faults, unsupported;
  std::error_code ignored;  // the file was opened
  const std::uintmax_t most = std::max<std::uintmax_t>(
      kAlwaysUnpacked, kMostPacking * std::filesystem::file_size(file, ignored));
  std::uintmax_t bytes = 0;
  for (const std::string& entry : zip->names()) {
    if (faults.size() >= kMostFaultsKept) break;
    const std::string array = entry.substr(0, entry.size() - kEnding.size());
    try {
      read_array(*zip, entry, read);
      bytes += read.arrays.back().bytes.size();
    } catch (const InvalidInput& damaged) {
      for (Diagnostic fault : damaged.diagnostics()) {
        fault.file = file.string();
        fault.where = array;
        faults.push_back(std::move(fault));
      }
    } catch (const FileError&) {
      throw;
    } catch (const UnsupportedType& type) {
      read.left_out[array] = type.what();
      unsupported.push_back({Severity::kError, file.string(), array, "bad-array", type.what()});
    } catch (const Error& wrong) {
      faults.push_back({Severity::kError, file.string(), array, "bad-array", wrong.what()});
    }
    if (bytes > most) {
      refuse(file.string(), "", "too-large",
             fmt::format("its arrays have more than {} bytes, {} times those of the file", most,
                         kMostPacking));
    }
  }
  if (!faults.empty() || read.arrays.empty()) {
    faults.insert(faults.begin(), unsupported.begin(), unsupported.end());
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
  return read;
}

}  // namespace

std::size_t size_of(DType type) noexcept {
  constexpr std::array<std::size_t, 9> kSizes{2, 2, 4, 8, 4, 8, 1, 8, 1};
  return kSizes[static_cast<std::size_t>(type)];
}

std::size_t NamedArray::elements() const noexcept {
  std::size_t product = 1;
  for (const std::int64_t side : shape) product *= static_cast<std::size_t>(side);
  return product;
}

struct TensorFile::Impl {
  explicit Impl(const std::filesystem::path& file)
      : path(file), map(std::make_shared<const MappedFile>(file)) {
    const auto bytes = std::as_bytes(map->bytes());
    const std::string name = file.string();
    if (formats::looks_like_zip(bytes)) {
      stored = is_npz(file) ? read_npz(file) : formats::read_torch_zip(file);
    } else if (formats::looks_like_pickle(bytes)) {
      stored = formats::read_torch_pickle(bytes, name);
    } else if (formats::looks_like_tar(bytes)) {
      formats::refuse_tar(bytes, name);
    } else {
      stored = formats::read_safetensors(bytes, name);
    }
    std::ranges::sort(stored.arrays, {}, &NamedArray::name);
  }

  std::filesystem::path path;
  std::shared_ptr<const MappedFile> map;
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

const std::map<std::string, std::string>& TensorFile::left_out() const noexcept {
  return impl_->stored.left_out;
}

const std::map<std::string, std::string>& TensorFile::metadata() const noexcept {
  return impl_->stored.metadata;
}

const std::filesystem::path& TensorFile::path() const noexcept { return impl_->path; }

TensorFile TensorFile::renamed(std::string (*name)(std::string_view)) const {
  const auto other = std::make_shared<Impl>(*impl_);
  for (NamedArray& array : other->stored.arrays) array.name = name(array.name);
  std::ranges::sort(other->stored.arrays, {}, &NamedArray::name);
  other->stored.left_out.clear();
  for (const auto& [old, reason] : left_out()) other->stored.left_out.emplace(name(old), reason);
  TensorFile renamed;
  renamed.impl_ = other;
  return renamed;
}

std::string bare_name(std::string_view name) {
  constexpr std::array<std::string_view, 3> kAtStart{"module.", "_orig_mod.", "model."};
  constexpr std::array<std::string_view, 3> kAnywhere{"_orig_mod.", "_fsdp_wrapped_module.",
                                                      "_checkpoint_wrapped_module."};
  std::string bare;
  for (std::size_t at = 0; at < name.size();) {
    const std::size_t end = std::min(name.find('.', at), name.size() - 1) + 1;
    const std::string_view part = name.substr(at, end - at);  // with its full stop
    if (std::ranges::find(kAnywhere, part) == kAnywhere.end()) bare += part;
    at = end;
  }
  std::string_view rest = bare;
  while (true) {
    const auto wrapper = std::ranges::find_if(kAtStart, [&](std::string_view one) {
      return rest.size() > one.size() && rest.starts_with(one);
    });
    if (wrapper == kAtStart.end()) return std::string(rest);
    rest.remove_prefix(wrapper->size());
  }
}

void write_safetensors(const std::filesystem::path& file, std::span<const NamedArray> arrays,
                       const std::map<std::string, std::string>& metadata) {
  const formats::SafetensorsLayout layout = formats::lay_out_safetensors(arrays, metadata);
  for (const NamedArray& array : arrays) {
    const std::size_t bytes = *formats::bytes_of_shape(array.shape, array.type);
    if (array.bytes.size() != bytes) {
      throw ArgumentError(fmt::format("array {}: {} bytes, not the {} of its shape",
                                      quote(array.name, 100), array.bytes.size(), bytes));
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
