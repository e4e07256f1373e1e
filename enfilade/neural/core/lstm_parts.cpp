#include "enfilade/neural/core/lstm_parts.h"

#include <ATen/ATen.h>
#include <ATen/CPUGeneratorImpl.h>
#include <fmt/format.h>
#include <span>
#include <utility>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/neural/core/recurrent_ops.h"

namespace enfilade::neural::core {

void add_lstm(std::vector<core::ArraySpec>& specs, const std::string& prefix,
              const std::string& suffix, std::int64_t input, std::int64_t hidden) {
  specs.push_back({prefix + "weight_ih" + suffix, {4 * hidden, input}});
  specs.push_back({prefix + "weight_hh" + suffix, {4 * hidden, hidden}});
  specs.push_back({prefix + "bias_ih" + suffix, {4 * hidden}});
  specs.push_back({prefix + "bias_hh" + suffix, {4 * hidden}});
}

at::Tensor first_values(const core::ArraySpec& spec, bool words, double bound, std::uint64_t seed) {
  Rng rng(seed, stream_of(spec.name.data(), spec.name.size()));
  at::Generator generator = at::detail::createCPUGenerator(rng.next());
  at::Tensor values = at::empty(spec.shape, at::kFloat);
  if (words) {
    values.normal_(0, 1, generator);
    values[0].zero_();
  } else {
    values.uniform_(-bound, bound, generator);
  }
  return values;
}

const at::Tensor& weight_of(const core::Weights& weights, std::string_view name) {
  const auto found = weights.find(name);
  if (found == weights.end()) throw LookupError(fmt::format("the network has no array {:?}", name));
  return found->second;
}

LstmOutput read_rows(const core::Weights& weights, const std::string& name, bool bidirectional,
                     const at::Tensor& x, const at::Tensor& lengths) {
  const std::span<const std::int64_t> all(lengths.data_ptr<std::int64_t>(),
                                          static_cast<std::size_t>(lengths.numel()));
  const std::vector<std::int64_t> steps(all.begin(), all.end());
  std::vector<at::Tensor> outputs, hidden, cells;
  for (const bool backwards : {false, true}) {
    if (backwards && !bidirectional) break;
    const std::string suffix = backwards ? "_l0_reverse" : "_l0";
    const auto part = [&](const char* kind) { return weight_of(weights, name + kind + suffix); };
    const core::LstmRead read = core::read_lstm(
        x, steps, {part(".weight_ih"), part(".weight_hh"), part(".bias_ih"), part(".bias_hh")},
        backwards);
    outputs.push_back(read.outputs);
    hidden.push_back(read.hidden);
    cells.push_back(read.cell);
  }
  return {at::cat(outputs, 2), at::stack(hidden), at::stack(cells)};
}

at::Tensor drop_pictures(const at::Tensor& features, std::size_t image, double rate,
                         core::Dropout& dropout) {
  if (rate == 0 || image == 0) return features;
  const auto pictures = static_cast<std::int64_t>(image);
  const std::int64_t angle = features.size(-1) - pictures;
  return at::cat(
      {dropout(features.narrow(-1, 0, pictures), rate), features.narrow(-1, pictures, angle)}, -1);
}

std::size_t MatrixSides::side(std::string_view name, std::size_t at) {
  const features::NamedArray* const array = file_.find(name);
  if (array != nullptr && array->shape.size() == 2) {
    return static_cast<std::size_t>(array->shape[at]);
  }
  faults_.push_back({Severity::kError, file_.path().string(), std::string(name),
                     array == nullptr ? "missing-array" : "wrong-shape",
                     array == nullptr ? fmt::format("not in the file; an array of {}", network_)
                                      : fmt::format("{} sides, not 2", array->shape.size())});
  return 0;
}

std::size_t MatrixSides::image(std::string_view name, std::size_t feature, std::size_t angle) {
  if (!faults_.empty()) throw InvalidInput(std::move(faults_));
  if (feature < angle) {
    refuse(file_.path().string(), std::string(name), "wrong-shape",
           fmt::format("{} numbers a view, fewer than the {} of its angle", feature, angle));
  }
  return feature - angle;
}

}  // namespace enfilade::neural::core
