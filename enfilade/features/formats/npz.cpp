#include <fmt/format.h>
#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/features/formats/stored_arrays.h"
#include "enfilade/scan/file_tree.h"
#include "enfilade/scan/npy.h"

namespace enfilade::features::formats {
namespace {

constexpr std::string_view kEnding = ".npy";

std::optional<DType> type_of(const scan::NpyArray& array) {
  const std::size_t bytes = array.item_bytes();
  switch (array.kind()) {
    case scan::NpyKind::kFloat:
      if (bytes == 2) return DType::kFloat16;
      return bytes == 4 ? DType::kFloat32 : DType::kFloat64;
    case scan::NpyKind::kInteger:
      if (bytes == 4) return DType::kInt32;
      if (bytes == 8) return DType::kInt64;
      break;
    case scan::NpyKind::kUnsigned:
      if (bytes == 1) return DType::kUint8;
      if (bytes == 8) return DType::kUint64;
      break;
    case scan::NpyKind::kBool:
      return DType::kBool;
    default:
      break;
  }
  return std::nullopt;
}

void read_array(const scan::FileTree& zip, const std::string& entry, StoredArrays& into) {
  const auto array = scan::NpyArray::parse(zip.read(entry).value());
  const auto type = type_of(array);
  if (!type) {
    throw Error(fmt::format("elements of type {:?}; f2, f4, f8, i4, i8, u1, u8 and b1 are read",
                            array.type()));
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

}  // namespace

bool is_npz(const std::filesystem::path& file) {
  const auto names = scan::FileTree::zip(file, scan::ZipNames::kPaths)->names();
  return !names.empty() && std::ranges::all_of(names, [](const std::string& name) {
    return name.ends_with(kEnding);
  });
}

StoredArrays read_npz(const std::filesystem::path& file) {
  const auto zip = scan::FileTree::zip(file, scan::ZipNames::kPaths);
  StoredArrays read;
  std::vector<Diagnostic> faults;
  for (const std::string& entry : zip->names()) {
    if (faults.size() >= kMostFaultsKept) break;
    const std::string array = entry.substr(0, entry.size() - kEnding.size());
    try {
      read_array(*zip, entry, read);
    } catch (const InvalidInput& damaged) {
      for (Diagnostic fault : damaged.diagnostics()) {
        fault.file = file.string();
        fault.where = array;
        faults.push_back(std::move(fault));
      }
    } catch (const FileError&) {
      throw;
    } catch (const Error& wrong) {
      faults.push_back({Severity::kError, file.string(), array, "bad-array", wrong.what()});
    }
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
  return read;
}

}  // namespace enfilade::features::formats
