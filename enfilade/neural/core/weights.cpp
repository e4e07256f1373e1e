#include "enfilade/neural/core/weights.h"

#include <ATen/ATen.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <xxhash.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::neural::core {
namespace {

std::optional<at::ScalarType> floating_type(features::DType type) {
  if (type == features::DType::kFloat16) return at::kHalf;
  if (type == features::DType::kBFloat16) return at::kBFloat16;
  if (type == features::DType::kFloat32) return at::kFloat;
  if (type == features::DType::kFloat64) return at::kDouble;
  return std::nullopt;
}

class Reader {
 public:
  Reader(const features::TensorFile& file, bool (*ignored)(std::string_view))
      : file_(file), ignored_(ignored) {
    for (const features::NamedArray& array : file.arrays()) {
      const auto& [other, fits] = arrays_.emplace(features::bare_name(array.name), &array);
      if (!fits && !ignored_(other->first)) {
        fault(array.name, "repeated-array",
              fmt::format("the same array of the network as {:?}, by another prefix",
                          other->second->name));
      }
    }
    for (const auto& [name, reason] : file.left_out()) {
      left_out_.emplace(features::bare_name(name), reason);
    }
  }

  Weights read(std::span<const ArraySpec> wanted) {
    Weights weights;
    for (const ArraySpec& spec : wanted) {
      if (at::Tensor values = take(spec); values.defined()) weights.emplace(spec.name, values);
    }
    for (const auto& [name, array] : arrays_) {
      if (ignored_(name)) continue;
      fault(
          array->name, "surplus-array",
          fmt::format("shape [{}]; this network has no such array", fmt::join(array->shape, ", ")));
    }
    if (!faults_.empty()) throw InvalidInput(std::move(faults_));
    return weights;
  }

 private:
  void fault(const std::string& array, std::string code, std::string message) {
    faults_.push_back(
        {Severity::kError, file_.path().string(), array, std::move(code), std::move(message)});
  }

  at::Tensor take(const ArraySpec& spec) {
    const std::string name = features::bare_name(spec.name);
    const auto found = arrays_.find(name);
    if (found == arrays_.end()) {
      const auto reason = left_out_.find(name);
      fault(spec.name, "missing-array",
            fmt::format("{}; shape [{}] is expected",
                        reason == left_out_.end() ? "not in the file" : reason->second,
                        fmt::join(spec.shape, ", ")));
      return {};
    }
    const features::NamedArray& array = *found->second;
    arrays_.erase(found);
    const std::optional<at::ScalarType> type = floating_type(array.type);
    if (array.shape != spec.shape) {
      fault(array.name, "wrong-shape",
            fmt::format("shape [{}], [{}] is expected", fmt::join(array.shape, ", "),
                        fmt::join(spec.shape, ", ")));
    } else if (!type) {
      fault(array.name, "wrong-type",
            fmt::format("{}; floating-point numbers are expected", enum_name(array.type)));
    } else {
      return values(array, *type);
    }
    return {};
  }

  at::Tensor values(const features::NamedArray& array, at::ScalarType type) {
    // An aligned copy that outlives the file's mapping.
    at::Tensor tensor = at::empty(array.shape, type);
    std::ranges::copy(array.bytes, static_cast<std::byte*>(tensor.data_ptr()));
    tensor = tensor.to(at::kFloat);
    if (!at::isfinite(tensor).all().item<bool>()) {
      fault(array.name, "not-finite", "has infinities or NaN");
      return {};
    }
    return tensor;
  }

  const features::TensorFile& file_;
  bool (*ignored_)(std::string_view);
  std::map<std::string, const features::NamedArray*, std::less<>> arrays_;  ///< by bare names
  std::map<std::string, std::string, std::less<>> left_out_;
  std::vector<Diagnostic> faults_;
};

}  // namespace

Shapes::Shapes(const features::TensorFile& file) : file_(file) {
  for (const features::NamedArray& array : file.arrays()) {
    arrays_.emplace(features::bare_name(array.name), &array);
  }
}

const features::NamedArray* Shapes::find(std::string_view name) const {
  const auto found = arrays_.find(name);
  return found == arrays_.end() ? nullptr : found->second;
}

std::int64_t Shapes::side(const std::string& name, std::size_t which) {
  const features::NamedArray* const array = find(name);
  if (array != nullptr && array->shape.size() == 2) return array->shape[which];
  std::string reason = array == nullptr ? "not in the file; a matrix is expected"
                                        : fmt::format("{} sides, not 2", array->shape.size());
  for (const auto& [one, why] : file_.left_out()) {
    if (features::bare_name(one) == name) reason = why;
  }
  faults_.push_back({Severity::kError, file_.path().string(), name,
                     array == nullptr ? "missing-array" : "wrong-shape", std::move(reason)});
  return 1;
}

void Shapes::check() {
  if (!faults_.empty()) throw InvalidInput(std::move(faults_));
}

void add_layer(std::vector<ArraySpec>& specs, const std::string& name,
               std::vector<std::int64_t> shape) {
  const std::int64_t out = shape[0];
  specs.push_back({name + ".weight", std::move(shape)});
  specs.push_back({name + ".bias", {out}});
}

Weights read_weights(const features::TensorFile& file, std::span<const ArraySpec> wanted,
                     bool (*ignored)(std::string_view)) {
  return Reader(file, ignored).read(wanted);
}

void make_trainable(Weights& weights, c10::Device device) {
  for (auto& [name, values] : weights) values = values.to(device).requires_grad_();
}

Weights on_cpu(const Weights& weights) {
  Weights copies;
  for (const auto& [name, values] : weights) copies.emplace(name, values.detach().to(at::kCPU));
  return copies;
}

std::vector<features::NamedArray> as_arrays(const Weights& weights) {
  std::vector<features::NamedArray> arrays;
  for (const auto& [name, values] : weights) {
    const std::span<const float> numbers(values.data_ptr<float>(),
                                         static_cast<std::size_t>(values.numel()));
    arrays.push_back(
        {name, features::DType::kFloat32, values.sizes().vec(), std::as_bytes(numbers)});
  }
  return arrays;
}

std::string hash_of(const Weights& weights) {
  std::uint64_t hash = 0;
  for (const features::NamedArray& array : as_arrays(weights)) {
    hash = XXH3_64bits_withSeed(array.name.data(), array.name.size(), hash);
    hash = XXH3_64bits_withSeed(array.bytes.data(), array.bytes.size(), hash);
  }
  return fmt::format("{:016x}", hash);
}

SavedState as_state(const Weights& weights) {
  SavedState state;
  const Weights values = on_cpu(weights);
  for (features::NamedArray& array : as_arrays(values)) {
    state.storage.emplace_back(array.bytes.begin(), array.bytes.end());
    array.bytes = state.storage.back();
    state.arrays.push_back(std::move(array));
  }
  return state;
}

at::Tensor normal(const std::vector<std::int64_t>& shape, double deviation, Rng& rng) {
  at::Tensor tensor = at::empty(shape, at::kFloat);
  const std::span<float> numbers(tensor.data_ptr<float>(),
                                 static_cast<std::size_t>(tensor.numel()));
  for (std::size_t i = 0; i < numbers.size(); i += 2) {  // Box and Muller: two at a time
    const double radius = deviation * std::sqrt(-2 * std::log1p(-rng.uniform()));
    const double angle = 2 * std::numbers::pi * rng.uniform();
    numbers[i] = static_cast<float>(radius * std::cos(angle));
    if (i + 1 < numbers.size()) numbers[i + 1] = static_cast<float>(radius * std::sin(angle));
  }
  return tensor;
}

at::Tensor he_normal(const std::vector<std::int64_t>& shape, Rng& rng) {
  std::int64_t inputs = 1;
  for (std::size_t i = 1; i < shape.size(); ++i) inputs *= shape[i];
  return normal(shape, std::sqrt(2.0 / static_cast<double>(inputs)), rng);
}

}  // namespace enfilade::neural::core
