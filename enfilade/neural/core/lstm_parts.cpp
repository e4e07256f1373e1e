#include "enfilade/neural/core/lstm_parts.h"

#include <ATen/ATen.h>
#include <ATen/CPUGeneratorImpl.h>
#include <fmt/format.h>
#include <cmath>

#include "enfilade/core/rng.h"
#include "enfilade/neural/core/recurrent_ops.h"

namespace enfilade::neural::core {

void add_lstm(std::vector<ArraySpec>& specs, const std::string& prefix, const std::string& suffix,
              std::int64_t input, std::int64_t hidden) {
  specs.push_back({prefix + "weight_ih" + suffix, {4 * hidden, input}});
  specs.push_back({prefix + "weight_hh" + suffix, {4 * hidden, hidden}});
  specs.push_back({prefix + "bias_ih" + suffix, {4 * hidden}});
  specs.push_back({prefix + "bias_hh" + suffix, {4 * hidden}});
}

void add_attention(std::vector<ArraySpec>& specs, const std::string& name, std::int64_t hidden,
                   std::int64_t context) {
  specs.push_back({name + ".linear_in.weight", {context, hidden}});
  specs.push_back({name + ".linear_out.weight", {hidden, hidden + context}});
}

namespace {

at::Tensor first_values(const ArraySpec& spec, std::int64_t fan, std::uint64_t seed) {
  Rng rng(seed, stream_of(spec.name.data(), spec.name.size()));
  at::Generator generator = at::detail::createCPUGenerator(rng.next());
  at::Tensor values = at::empty(spec.shape, at::kFloat);
  if (fan == 0) {
    values.normal_(0, 1, generator);
    values[0].zero_();
  } else {
    const double bound = 1 / std::sqrt(static_cast<double>(fan));
    values.uniform_(-bound, bound, generator);
  }
  return values;
}

const at::Tensor& weight_of(const Weights& weights, std::string_view name) {
  const auto found = weights.find(name);
  if (found == weights.end()) throw LookupError(fmt::format("the network has no array {:?}", name));
  return found->second;
}

}  // namespace

LstmNetwork::LstmNetwork(std::span<const ArraySpec> arrays, const FanOf& fan_of, std::uint64_t seed,
                         c10::Device device)
    : device_(device) {
  for (const ArraySpec& spec : arrays) {
    weights_.emplace(spec.name, first_values(spec, fan_of(spec), seed));
  }
  make_trainable(weights_, device);
}

LstmNetwork::LstmNetwork(std::span<const ArraySpec> arrays, const features::TensorFile& file,
                         c10::Device device, bool (*ignored)(std::string_view))
    : weights_(read_weights(file, arrays, ignored)), device_(device) {
  make_trainable(weights_, device);
}

const at::Tensor& LstmNetwork::weight(std::string_view name) const {
  return weight_of(weights_, name);
}

void LstmNetwork::set_dropout(std::optional<std::uint64_t> seed) {
  dropout_.reset();
  if (seed) dropout_.emplace(*seed, device_);
}

at::Tensor LstmNetwork::drop(const at::Tensor& x, double rate) {
  return dropout_ ? (*dropout_)(x, rate) : x;
}

at::Tensor LstmNetwork::drop_pictures(const at::Tensor& features, std::size_t image, double rate) {
  if (!dropout_ || rate == 0 || image == 0) return features;
  const auto pictures = static_cast<std::int64_t>(image);
  const std::int64_t angle = features.size(-1) - pictures;
  return at::cat(
      {drop(features.narrow(-1, 0, pictures), rate), features.narrow(-1, pictures, angle)}, -1);
}

LstmOutput read_rows(const Weights& weights, const std::string& name, bool bidirectional,
                     const at::Tensor& x, const at::Tensor& lengths) {
  const std::span<const std::int64_t> all(lengths.data_ptr<std::int64_t>(),
                                          static_cast<std::size_t>(lengths.numel()));
  const std::vector<std::int64_t> steps(all.begin(), all.end());
  std::vector<at::Tensor> outputs, hidden, cells;
  for (const bool backwards : {false, true}) {
    if (backwards && !bidirectional) break;
    const std::string suffix = backwards ? "_l0_reverse" : "_l0";
    const auto part = [&](const char* kind) { return weight_of(weights, name + kind + suffix); };
    const LstmRead read = read_lstm(
        x, steps, {part(".weight_ih"), part(".weight_hh"), part(".bias_ih"), part(".bias_hh")},
        backwards);
    outputs.push_back(read.outputs);
    hidden.push_back(read.hidden);
    cells.push_back(read.cell);
  }
  return {at::cat(outputs, 2), at::stack(hidden), at::stack(cells)};
}

}  // namespace enfilade::neural::core
