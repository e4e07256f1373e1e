#include "enfilade/neural/seq2seq/network.h"

#include <ATen/ATen.h>
#include <c10/core/InferenceMode.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstring>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/neural/core/torch_device.h"
#include "enfilade/neural/seq2seq/seq2seq.h"

namespace enfilade::neural::seq2seq {
namespace {

constexpr const char* kFirst = "adam.first.";
constexpr const char* kSecond = "adam.second.";
constexpr const char* kUpdates = "adam.updates";

std::unique_ptr<Kernels> kernels_for(const at::Device& device) {
  return device.is_cpu() ? make_cpu_kernels() : make_aten_kernels();
}

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
             fmt::format("is {} [{}], not {} [{}]", to_string(array->type),
                         fmt::join(array->shape, ", "), to_string(type), fmt::join(shape, ", ")));
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

struct Network::Impl : Seq2Seq {
  Impl(const models::NetworkConfig& config, const at::Device& device)
      : Seq2Seq(config, at::TensorOptions().dtype(at::kFloat).device(device), kernels_for(device)) {
  }
};

Seq2Seq& implementation_of(Network& network) { return network.implementation(); }

Network::Network(const models::NetworkConfig& config, std::uint64_t seed,
                 const std::string& device) {
  const c10::InferenceMode guard;
  impl_ = std::make_unique<Impl>(config, core::open_agents_device(device));
  impl_->parameters().initialise(seed);
}
Network::~Network() = default;
Network::Network(Network&&) noexcept = default;
Network& Network::operator=(Network&&) noexcept = default;

const models::NetworkConfig& Network::config() const noexcept { return impl_->config(); }

RolloutResult Network::rollout(const InstructionBatch& instructions, Environment& environment,
                               const RolloutOptions& options, const StepObserver& observer) {
  const c10::InferenceMode guard;
  return impl_->rollout(instructions, environment, options, WithGradients::kNo, observer);
}

RolloutResult Network::rollout_with_gradients(const InstructionBatch& instructions,
                                              Environment& environment,
                                              const RolloutOptions& options,
                                              const std::function<void()>& decoder_done) {
  const c10::InferenceMode guard;
  return impl_->rollout(instructions, environment, options, WithGradients::kYes, {}, decoder_done);
}

void Network::begin(const InstructionBatch& instructions, std::size_t max_steps) {
  const c10::InferenceMode guard;
  impl_->begin(instructions, max_steps);
}

void Network::act(std::span<const float> features, std::span<const std::uint8_t> forward_open,
                  std::span<std::int32_t> actions) {
  const c10::InferenceMode guard;
  impl_->act(features, forward_open, actions);
}

void Network::update(const models::AdamConfig& config) {
  const c10::InferenceMode guard;
  impl_->update(config);
}

std::uint64_t Network::updates() const noexcept { return impl_->parameters().updates; }

Network::State Network::weights() const {
  State state;
  add_arrays(state, "", impl_->parameters(), impl_->parameters().flat_weights);
  return state;
}

Network::State Network::gradients() const {
  State state;
  add_arrays(state, "", impl_->parameters(), impl_->parameters().flat_gradients);
  return state;
}

Network::State Network::training_state() const {
  State state = weights();
  const Parameters& parameters = impl_->parameters();
  add_arrays(state, kFirst, parameters, parameters.first);
  add_arrays(state, kSecond, parameters, parameters.second);
  add_array(state, kUpdates, features::DType::kUint64, {}, &parameters.updates,
            sizeof parameters.updates);
  return state;
}

void Network::load_weights(const features::TensorFile& file) {
  const c10::InferenceMode guard;
  Parameters& parameters = impl_->parameters();
  Loader loader(file);
  loader.expect_weights("", parameters);
  loader.finish();
  loader.load("", parameters, parameters.flat_weights);
}

void Network::load_training_state(const features::TensorFile& file) {
  const c10::InferenceMode guard;
  Parameters& parameters = impl_->parameters();
  Loader loader(file);
  for (const char* prefix : {"", kFirst, kSecond}) loader.expect_weights(prefix, parameters);
  loader.expect(kUpdates, features::DType::kUint64, {});
  loader.finish();
  loader.load("", parameters, parameters.flat_weights);
  loader.load(kFirst, parameters, parameters.first);
  loader.load(kSecond, parameters, parameters.second);
  std::memcpy(&parameters.updates, file.find(kUpdates)->bytes.data(), sizeof parameters.updates);
}

}  // namespace enfilade::neural::seq2seq
