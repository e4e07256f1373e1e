#include "enfilade/features/formats/object_hdf5.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/features/formats/feature_rows.h"
#include "enfilade/features/formats/hdf5_datasets.h"

namespace enfilade::features::formats {
namespace {

using Handle = Hdf5Handle;
using Pairs = std::vector<double>;  // row after row

// What the forked copy hands over: numbers and texts, one after the other.
class Out {
 public:
  explicit Out(SharedMemory& memory) : memory_(memory) {}

  template <class T>
  void number(T value) {
    const auto* const bytes = reinterpret_cast<const std::byte*>(&value);
    buffer_.insert(buffer_.end(), bytes, bytes + sizeof(value));
  }
  void text(std::string_view value) {
    number<std::uint64_t>(value.size());
    const auto bytes = std::as_bytes(std::span(value));
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  }
  void numbers(std::span<const float> values) {
    buffer_.resize((buffer_.size() + at_ + 7) / 8 * 8 - at_);
    const auto bytes = std::as_bytes(values);
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  }
  void flush() {
    memory_.write_at(at_, buffer_);
    at_ += buffer_.size();
    buffer_.clear();
  }

 private:
  SharedMemory& memory_;
  std::vector<std::byte> buffer_;
  std::uint64_t at_ = 0;
};

// Reads it in the same order. \throws InvalidInput where it ends too early
class In {
 public:
  In(std::span<const std::uint8_t> bytes, const std::string& file)
      : bytes_(std::as_bytes(bytes)), file_(file) {}

  template <class T>
  T number() {
    T value{};
    std::memcpy(&value, take(sizeof(value)).data(), sizeof(value));
    return value;
  }
  std::string text() {
    const auto bytes = take(number<std::uint64_t>());
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  std::span<const std::byte> numbers(std::uint64_t n) {
    take((at_ + 7) / 8 * 8 - at_);
    if (n > bytes_.size()) take(n);
    return take(n * sizeof(float));
  }

 private:
  std::span<const std::byte> take(std::uint64_t n) {
    if (n > bytes_.size() - at_) refuse(file_, "", "bad-hdf5", "reading it ended too early");
    const auto part = bytes_.subspan(at_, n);
    at_ += n;
    return part;
  }

  std::span<const std::byte> bytes_;
  const std::string& file_;
  std::uint64_t at_ = 0;
};

class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : file_(path, path.string()) {}

  void copy_to(SharedMemory& memory) {
    const std::vector<std::string> names = file_.datasets();
    Out out(memory);
    out.number<std::uint64_t>(names.size());
    for (const std::string& name : names) {
      copy_viewpoint(name, out);
      out.flush();
    }
    out.flush();
  }

 private:
  void copy_viewpoint(const std::string& name, Out& out) {
    key_of(name, file_.name());
    const Handle dataset = file_.open_dataset(name);
    const Handle type(H5Dget_type(dataset.id()), H5Tclose);
    const auto size = file_.size_of(name, dataset);
    file_.check_layout(name, dataset);
    if (!is_plain_float(type.id())) {
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
      file_.fail_damaged(name);
    }
    if (!std::ranges::all_of(numbers, [](float x) { return std::isfinite(x); })) {
      file_.fail(name, "not-finite", "a number that is infinite or NaN");
    }
    out.text(name);
    out.number<std::uint64_t>(size[0]);
    out.number<std::uint64_t>(size[1]);
    copy_objects(name, dataset, size[0], out);
    out.numbers(numbers);
  }

  void copy_objects(const std::string& name, const Handle& dataset, std::size_t n, Out& out) {
    const std::vector<std::string> ids = texts(name, dataset, n);
    const Pairs directions = numbers(name, dataset, "directions", n, 2);
    const bool sized = H5Aexists(dataset.id(), "sizes") > 0;
    const Pairs sizes =
        sized ? numbers(name, dataset, "sizes", n, 2) : numbers(name, dataset, "bboxes", n, 4);
    for (std::size_t i = 0; i < n; ++i) {
      out.text(ids[i]);
      out.number(directions[2 * i]);
      out.number(directions[2 * i + 1]);
      // SOON's boxes are of square pictures.
      constexpr double kWide = 640. / 600, kHigh = 480. / 600;
      out.number(sized ? sizes[2 * i] : (sizes[4 * i + 2] - sizes[4 * i]) * kWide);
      out.number(sized ? sizes[2 * i + 1] : (sizes[4 * i + 3] - sizes[4 * i + 1]) * kHigh);
    }
  }

  Handle attribute(const std::string& dataset_name, const Handle& dataset, const char* name,
                   std::size_t elements) const {
    if (H5Aexists(dataset.id(), name) <= 0) {
      file_.fail(dataset_name, "missing-attribute",
                 fmt::format("has no attribute {:?}, which objects have", name));
    }
    Handle opened(H5Aopen(dataset.id(), name, H5P_DEFAULT), H5Aclose);
    const Handle space(H5Aget_space(opened.id()), H5Sclose);
    const hssize_t found = H5Sget_simple_extent_npoints(space.id());
    if (found != static_cast<hssize_t>(elements)) {
      file_.fail(dataset_name, "wrong-size",
                 fmt::format("attribute {:?} of {} elements, not {}", name, found, elements));
    }
    return opened;
  }

  Pairs numbers(const std::string& dataset_name, const Handle& dataset, const char* name,
                std::size_t rows, std::size_t columns) const {
    const Handle opened = attribute(dataset_name, dataset, name, rows * columns);
    const Handle type(H5Aget_type(opened.id()), H5Tclose);
    Pairs values(rows * columns);
    if (!is_plain_number(type.id()) || H5Aread(opened.id(), H5T_NATIVE_DOUBLE, values.data()) < 0 ||
        !std::ranges::all_of(values, [](double x) { return std::isfinite(x); })) {
      file_.fail(dataset_name, "bad-number", fmt::format("attribute {:?}: not numbers", name));
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

  Hdf5Source file_;
  hsize_t dimensions_ = 0;
};

ViewpointObjects viewpoint_of(In& in, std::size_t& dimensions) {
  ViewpointObjects viewpoint;
  viewpoint.name = in.text();
  const auto n = in.number<std::uint64_t>();
  dimensions = in.number<std::uint64_t>();
  for (std::uint64_t i = 0; i < n; ++i) {
    ObjectView object;
    object.id = in.text();
    object.heading = Radians(in.number<double>());
    object.elevation = Radians(in.number<double>());
    object.width = in.number<double>();
    object.height = in.number<double>();
    viewpoint.objects.push_back(std::move(object));
  }
  viewpoint.numbers = in.numbers(n * dimensions);
  return viewpoint;
}

}  // namespace

ObjectRows read_object_hdf5(const std::filesystem::path& file) {
  ObjectRows rows;
  rows.memory = read_isolated(file, [&](SharedMemory& memory) { Reader(file).copy_to(memory); });
  const std::string name = file.string();
  In in(rows.memory->bytes(), name);
  const auto count = in.number<std::uint64_t>();
  for (std::uint64_t i = 0; i < count; ++i) {
    rows.viewpoints.push_back(viewpoint_of(in, rows.dimensions));
  }
  if (rows.viewpoints.empty()) refuse(name, "", "no-features", "holds no viewpoint's objects");
  return rows;
}

}  // namespace enfilade::features::formats
