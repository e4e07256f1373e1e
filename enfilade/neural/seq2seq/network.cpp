#include "enfilade/neural/seq2seq/seq2seq.h"

#include <c10/core/InferenceMode.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <cstring>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/neural/core/torch_device.h"

namespace enfilade::neural::seq2seq {
namespace {

constexpr const char* kFirst = "adam.first.";
constexpr const char* kSecond = "adam.second.";
constexpr const char* kUpdates = "adam.updates";

void add_array(Network::State& state, std::string name, features::DType type,
               std::vector<std::int64_t> shape, const void* data, std::size_t bytes) {
  std::vector<std::byte> copy(bytes);
  std::memcpy(copy.data(), data, bytes);
  state.storage.push_back(std::move(copy));
  state.arrays.push_back({std::move(name), type, std::move(shape), state.storage.back()});
}

void add_arrays(Network::State& state, const std::string& prefix, const Parameters& parameters,
                const at::Tensor& flat) {
  const c10::InferenceMode guard;
  const at::Tensor host = flat.to(at::kCPU);
  for (const WeightInfo& info : parameters.infos()) {
    add_array(state, prefix + info.name, features::DType::kFloat32, info.shape,
              host.data_ptr<float>() + info.begin,
              static_cast<std::size_t>(info.elements) * sizeof(float));
  }
}

/// Copies arrays out of a file, after it has found all that is wrong with them.
class Loader {
 public:
  explicit Loader(const features::TensorFile& file) : file_(file) {}

  void expect(const std::string& name, features::DType type,
              const std::vector<std::int64_t>& shape) {
    expected_.push_back(name);
    const features::NamedArray* array = file_.find(name);
    if (array == nullptr) {
      report(name, "missing-array", "is not in the file");
    } else if (array->type != type || array->shape != shape) {
      report(name, "array-shape",
             fmt::format("is {} [{}], not {} [{}]", enum_name(array->type),
                         fmt::join(array->shape, ", "), enum_name(type), fmt::join(shape, ", ")));
    }
  }
  void expect_weights(const std::string& prefix, const Parameters& parameters) {
    for (const WeightInfo& info : parameters.infos()) {
      expect(prefix + info.name, features::DType::kFloat32, info.shape);
    }
  }
  void finish() {
    for (const features::NamedArray& array : file_.arrays()) {
      if (std::find(expected_.begin(), expected_.end(), array.name) == expected_.end()) {
        report(array.name, "surplus-array", "is none of this network's");
      }
    }
    if (!found_.empty()) throw InvalidInput(std::move(found_));
  }

  void load(const std::string& prefix, const Parameters& parameters, const at::Tensor& flat) const {
    const at::Tensor host = at::zeros(flat.sizes(), at::TensorOptions().dtype(at::kFloat));
    for (const WeightInfo& info : parameters.infos()) {
      const auto bytes = file_.find(prefix + info.name)->bytes;
      std::memcpy(host.data_ptr<float>() + info.begin, bytes.data(), bytes.size());
    }
    flat.copy_(host);
  }

 private:
  void report(const std::string& name, std::string code, std::string message) {
    found_.push_back(
        {Severity::kError, file_.path().string(), name, std::move(code), std::move(message)});
  }

  const features::TensorFile& file_;
  std::vector<std::string> expected_;
  std::vector<Diagnostic> found_;
};

}  // namespace

Network::Network(const models::NetworkConfig& config, std::uint64_t seed, const std::string& device)
    : Network(config, at::TensorOptions(at::kFloat).device(core::open_agents_device(device)),
              core::open_device(device).is_cpu() ? make_cpu_kernels() : make_aten_kernels()) {
  parameters_.initialise(seed);
}

Network::State Network::weights() const {
  State state;
  add_arrays(state, "", parameters_, parameters_.flat_weights);
  return state;
}

Network::State Network::gradients() const {
  State state;
  add_arrays(state, "", parameters_, parameters_.flat_gradients);
  return state;
}

Network::State Network::training_state() const {
  State state = weights();
  add_arrays(state, kFirst, parameters_, parameters_.first);
  add_arrays(state, kSecond, parameters_, parameters_.second);
  add_array(state, kUpdates, features::DType::kUint64, {}, &parameters_.updates,
            sizeof parameters_.updates);
  return state;
}

void Network::load_weights(const features::TensorFile& file) {
  const c10::InferenceMode guard;
  Loader loader(file);
  loader.expect_weights("", parameters_);
  loader.finish();
  loader.load("", parameters_, parameters_.flat_weights);
}

void Network::load_training_state(const features::TensorFile& file) {
  const c10::InferenceMode guard;
  Loader loader(file);
  for (const char* prefix : {"", kFirst, kSecond}) loader.expect_weights(prefix, parameters_);
  loader.expect(kUpdates, features::DType::kUint64, {});
  loader.finish();
  loader.load("", parameters_, parameters_.flat_weights);
  loader.load(kFirst, parameters_, parameters_.first);
  loader.load(kSecond, parameters_, parameters_.second);
  std::memcpy(&parameters_.updates, file.find(kUpdates)->bytes.data(), sizeof parameters_.updates);
}

}  // namespace enfilade::neural::seq2seq
