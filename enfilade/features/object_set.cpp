#include "enfilade/features/object_set.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/mapped_file.h"
#include "enfilade/core/names.h"
#include "enfilade/core/numbers.h"
#include "enfilade/features/formats/feature_rows.h"
#include "enfilade/features/formats/hdf5_datasets.h"

namespace enfilade::features {

// The objects of one viewpoint.
struct ViewpointObjects {
  std::string name;  ///< "<scan>_<viewpoint>"
  std::vector<ObjectView> objects;
  std::span<const std::byte> numbers;  ///< (objects, dimensions) of float32
};

namespace {

using formats::SharedMemory;
using Handle = formats::Hdf5Handle;
using Json = nlohmann::json;
using Pairs = std::vector<double>;  // row after row

class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : file_(path, path.string()) {}

  // What the forked copy hands over: where the index begins, the numbers of all viewpoints, and the
  // index. It has the dimensions, and each viewpoint's name, where its numbers begin, and objects.
  void copy_to(SharedMemory& memory) {
    Json viewpoints = Json::array();
    std::uint64_t at = sizeof(at);
    for (const std::string& name : file_.datasets()) {
      formats::key_of(name, file_.name());
      const Handle dataset = file_.open_dataset(name);
      const std::vector<float> numbers = read_features(name, dataset);
      viewpoints.push_back(
          Json::array({name, at, read_objects(name, dataset, numbers.size() / dimensions_)}));
      memory.write_at(at, std::as_bytes(std::span(numbers)));
      at += numbers.size() * sizeof(float);
    }
    const auto index = Json::to_cbor(Json::array({dimensions_, std::move(viewpoints)}));
    memory.write_at(at, std::as_bytes(std::span(index)));
    memory.write_at(0, std::as_bytes(std::span(&at, 1)));
  }

 private:
  std::vector<float> read_features(const std::string& name, const Handle& dataset) {
    const Handle type(H5Dget_type(dataset.id()), H5Tclose);
    const auto size = file_.size_of(name, dataset);
    file_.check_layout(name, dataset);
    if (!formats::is_plain_float(type.id())) {
      file_.fail(name, "unsupported-type", "not floating-point numbers of 16, 32 or 64 bits");
    }
    if (dimensions_ == 0) dimensions_ = size[1];
    if (size[1] != dimensions_) {
      file_.fail(name, "differing-size",
                 fmt::format("{} numbers an object, not {} as the first", size[1], dimensions_));
    }
    std::vector<float> numbers(size[0] * size[1]);
    if (H5Dread(dataset.id(), H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()) <
        0) {
      file_.fail_unread(name, dataset);
    }
    return numbers;
  }

  Json read_objects(const std::string& name, const Handle& dataset, std::size_t n) const {
    const std::vector<std::string> ids = texts(name, dataset, n);
    for (const std::string& id : ids) {
      // Numbers may be below 0.
      if (!is_id(id) && !parse_number<std::int64_t>(id))
        file_.fail(name, "bad-id", fault_of_id(id));
    }
    const Pairs directions = numbers(name, dataset, "directions", n, 2);
    const bool sized = H5Aexists(dataset.id(), "sizes") > 0;
    const Pairs sizes =
        sized ? numbers(name, dataset, "sizes", n, 2) : numbers(name, dataset, "bboxes", n, 4);
    Json objects = Json::array();
    for (std::size_t i = 0; i < n; ++i) {
      // SOON's boxes are of square pictures.
      constexpr double kWide = 640. / 600, kHigh = 480. / 600;
      objects.push_back(
          Json::array({ids[i], directions[2 * i], directions[2 * i + 1],
                       sized ? sizes[2 * i] : (sizes[4 * i + 2] - sizes[4 * i]) * kWide,
                       sized ? sizes[2 * i + 1] : (sizes[4 * i + 3] - sizes[4 * i + 1]) * kHigh}));
    }
    return objects;
  }

  Handle attribute(const std::string& dataset_name, const Handle& dataset, const char* name,
                   std::size_t elements) const {
    if (H5Aexists(dataset.id(), name) <= 0) {
      file_.fail(dataset_name, "missing-attribute",
                 fmt::format("has no attribute {}, which objects have", quote(name)));
    }
    Handle opened(H5Aopen(dataset.id(), name, H5P_DEFAULT), H5Aclose);
    const Handle space(H5Aget_space(opened.id()), H5Sclose);
    const hssize_t found = H5Sget_simple_extent_npoints(space.id());
    if (found != static_cast<hssize_t>(elements)) {
      file_.fail(dataset_name, "wrong-size",
                 fmt::format("attribute {} of {} elements, not {}", quote(name), found, elements));
    }
    return opened;
  }

  Pairs numbers(const std::string& dataset_name, const Handle& dataset, const char* name,
                std::size_t rows, std::size_t columns) const {
    const Handle opened = attribute(dataset_name, dataset, name, rows * columns);
    const Handle type(H5Aget_type(opened.id()), H5Tclose);
    Pairs values(rows * columns);
    if (!formats::is_plain_number(type.id()) ||
        H5Aread(opened.id(), H5T_NATIVE_DOUBLE, values.data()) < 0 ||
        !std::ranges::all_of(values, [](double x) { return std::isfinite(x); })) {
      file_.fail(dataset_name, "bad-number", fmt::format("attribute {}: not numbers", quote(name)));
    }
    return values;
  }

  // h5py writes texts of variable length, or of a fixed one; some files have whole numbers.
  std::vector<std::string> texts(const std::string& dataset_name, const Handle& dataset,
                                 std::size_t n) const {
    constexpr const char* kName = "obj_ids";
    const Handle opened = attribute(dataset_name, dataset, kName, n);
    const Handle type(H5Aget_type(opened.id()), H5Tclose);
    std::vector<std::string> found;
    if (H5Tget_class(type.id()) != H5T_STRING) {
      for (const double id : numbers(dataset_name, dataset, kName, n, 1)) {
        found.push_back(fmt::format("{:.0f}", id));
      }
      return found;
    }
    if (H5Tis_variable_str(type.id()) > 0) {
      std::vector<char*> pointers(n);
      if (H5Aread(opened.id(), type.id(), static_cast<void*>(pointers.data())) < 0) {
        file_.fail_damaged(dataset_name);
      }
      for (char* const one : pointers) {
        found.emplace_back(one == nullptr ? "" : one);
        H5free_memory(one);
      }
      return found;
    }
    const std::size_t size = H5Tget_size(type.id());
    constexpr std::size_t kLongest = 4096;
    if (size == 0 || size > kLongest) file_.fail_damaged(dataset_name);
    std::string all(n * size, '\0');
    if (H5Aread(opened.id(), type.id(), all.data()) < 0) file_.fail_damaged(dataset_name);
    for (std::size_t i = 0; i < n; ++i) {
      const std::string one = all.substr(i * size, size);
      found.push_back(one.substr(0, std::min(one.find('\0'), one.size())));
    }
    return found;
  }

  formats::Hdf5Source file_;
  hsize_t dimensions_ = 0;
};

std::vector<ObjectView> objects_of(const Json& list) {
  std::vector<ObjectView> objects;
  for (const Json& one : list) {
    objects.push_back({one.at(0).get<std::string>(), Radians(one.at(1).get<double>()),
                       Radians(one.at(2).get<double>()), one.at(3).get<double>(),
                       one.at(4).get<double>()});
  }
  return objects;
}

}  // namespace

struct ObjectSet::Impl {
  // Reads in a forked copy of this process, as damaged files can crash the library.
  explicit Impl(const std::filesystem::path& path)
      : file(path), memory(formats::read_isolated(path, [&](SharedMemory& shared) {
          Reader(path).copy_to(shared);
        })) {
    try {
      read_index();
    } catch (const Json::exception&) {
      fail_early();
    }
    for (const ViewpointObjects& viewpoint : viewpoints) {
      by_name.emplace(viewpoint.name, &viewpoint);
    }
    if (viewpoints.empty()) {
      refuse(file.string(), "", "no-features", "holds no viewpoint's objects");
    }
  }

  void read_index() {
    std::uint64_t at = 0;
    std::memcpy(&at, part(0, sizeof(at)).data(), sizeof(at));
    part(at, 0);
    const Json index = Json::from_cbor(memory->bytes().subspan(at));
    dimensions = index.at(0).get<std::size_t>();
    for (const Json& one : index.at(1)) {
      std::vector<ObjectView> objects = objects_of(one.at(2));
      const auto numbers =
          part(one.at(1).get<std::size_t>(), objects.size() * dimensions * sizeof(float));
      viewpoints.push_back({one.at(0).get<std::string>(), std::move(objects), numbers});
    }
  }

  std::span<const std::byte> part(std::size_t begin, std::size_t count) const {
    const auto bytes = std::as_bytes(memory->bytes());
    if (begin > bytes.size() || count > bytes.size() - begin) fail_early();
    return bytes.subspan(begin, count);
  }

  [[noreturn]] void fail_early() const {
    refuse(file.string(), "", "bad-hdf5", "reading it ended too early");
  }

  const ViewpointObjects* find(std::string_view scan, std::string_view viewpoint) const {
    const auto found = by_name.find(fmt::format("{}_{}", scan, viewpoint));
    return found == by_name.end() ? nullptr : found->second;
  }

  std::filesystem::path file;
  std::shared_ptr<const MappedFile> memory;
  std::size_t dimensions = 0;
  std::vector<ViewpointObjects> viewpoints;
  std::map<std::string, const ViewpointObjects*, std::less<>> by_name;
};

ObjectSet ObjectSet::open(const std::filesystem::path& file) {
  ObjectSet set;
  set.impl_ = std::make_shared<const Impl>(file);
  return set;
}

std::size_t ObjectSet::dimensions() const noexcept { return impl_->dimensions; }
const std::filesystem::path& ObjectSet::file() const noexcept { return impl_->file; }

std::span<const ObjectView> ObjectSet::objects(std::string_view scan,
                                               std::string_view viewpoint) const {
  const auto* const found = impl_->find(scan, viewpoint);
  return found == nullptr ? std::span<const ObjectView>() : std::span(found->objects);
}

void ObjectSet::copy(std::string_view scan, std::string_view viewpoint, std::size_t i,
                     std::span<float> out) const {
  const auto* const found = impl_->find(scan, viewpoint);
  EN_CHECK(found != nullptr);
  EN_CHECK_LT(i, found->objects.size());
  EN_CHECK_LE(out.size(), dimensions());
  const auto row = found->numbers.subspan(i * dimensions() * sizeof(float), out.size_bytes());
  if (!formats::copy_numbers(row.data(), DType::kFloat32, out)) {
    refuse(file().string(), formats::in_quotes(found->name), "not-finite",
           "a number that is infinite or NaN");
  }
}

}  // namespace enfilade::features
