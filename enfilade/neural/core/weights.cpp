#include "enfilade/neural/core/weights.h"

#include <ATen/ATen.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <xxhash.h>
#include <algorithm>
#include <optional>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::neural::core {
namespace {

constexpr std::string_view kWrapper = "module.";

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
      std::string_view name = array.name;
      if (name.starts_with(kWrapper)) name.remove_prefix(kWrapper.size());
      arrays_.emplace(name, &array);
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
    const auto found = arrays_.find(spec.name);
    if (found == arrays_.end()) {
      fault(spec.name, "missing-array",
            fmt::format("not in the file; shape [{}] is expected", fmt::join(spec.shape, ", ")));
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
            fmt::format("{}; floating-point numbers are expected", to_string(array.type)));
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
  std::map<std::string, const features::NamedArray*, std::less<>> arrays_;
  std::vector<Diagnostic> faults_;
};

}  // namespace

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

State as_state(const Weights& weights) {
  State state;
  const Weights values = on_cpu(weights);
  for (features::NamedArray& array : as_arrays(values)) {
    state.storage.emplace_back(array.bytes.begin(), array.bytes.end());
    array.bytes = state.storage.back();
    state.arrays.push_back(std::move(array));
  }
  return state;
}

}  // namespace enfilade::neural::core
