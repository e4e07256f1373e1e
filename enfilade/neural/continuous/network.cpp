#include "enfilade/neural/continuous/network.h"

#include <ATen/ATen.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "enfilade/neural/continuous/gru.h"
#include "enfilade/neural/core/lstm_parts.h"

namespace enfilade::neural::continuous {
namespace {

using core::ArraySpec;

constexpr const char* kWords = "instruction.embedding.weight";
constexpr const char* kActions = "action_embedding.weight";
constexpr std::size_t kBeginAndMask = 2;

std::int64_t whole(std::size_t size) { return static_cast<std::int64_t>(size); }

void add_linear(std::vector<ArraySpec>& specs, const std::string& name, std::int64_t in,
                std::int64_t out) {
  specs.push_back({name + ".weight", {out, in}});
  specs.push_back({name + ".bias", {out}});
}

// A network that was made blind has no use for the features; it still has a weight for one number.
std::int64_t picture_inputs(const Sizes& sizes) {
  return std::max<std::int64_t>(sizes.features, 1);
}

std::vector<ArraySpec> array_specs(const Sizes& sizes) {
  const models::Seq2SeqCeConfig& own = sizes.own;
  const std::int64_t hidden = whole(own.hidden);
  std::vector<ArraySpec> specs;
  specs.push_back({kWords, {sizes.words, whole(own.word_embedding)}});
  core::add_lstm(specs, "instruction.lstm.", "_l0", whole(own.word_embedding), whole(own.sentence));
  add_linear(specs, "picture", picture_inputs(sizes), whole(own.picture));
  add_linear(specs, "depth", kDepthSize, whole(own.depth));
  specs.push_back({kActions, {1 + kChoices, whole(own.action_embedding)}});
  const std::int64_t in = whole(own.sentence + own.picture + own.depth + own.action_embedding);
  specs.push_back({"gru.weight_ih_l0", {3 * hidden, in}});
  specs.push_back({"gru.weight_hh_l0", {3 * hidden, hidden}});
  specs.push_back({"gru.bias_ih_l0", {3 * hidden}});
  specs.push_back({"gru.bias_hh_l0", {3 * hidden}});
  add_linear(specs, "choice", hidden, kChoices);
  return specs;
}

// PyTorch draws uniformly below 1 / sqrt(of this): of recurrent layers their size, of linear ones
// their inputs.
std::int64_t fan_of(const Sizes& sizes, const std::string& name) {
  if (name.starts_with("instruction.lstm.")) return whole(sizes.own.sentence);
  if (name.starts_with("picture.")) return picture_inputs(sizes);
  if (name.starts_with("depth.")) return kDepthSize;
  return whole(sizes.own.hidden);
}

}  // namespace

Sizes sizes_of(const models::TrainConfig& config) {
  return {whole(config.network.vocabulary + kBeginAndMask), whole(config.network.features),
          config.seq2seq_ce};
}

CeNetwork::CeNetwork(const Sizes& sizes, std::uint64_t seed, c10::Device device)
    : sizes_(sizes), device_(device) {
  for (const ArraySpec& spec : array_specs(sizes)) {
    const bool table = spec.name == kWords || spec.name == kActions;
    const double bound = 1 / std::sqrt(static_cast<double>(fan_of(sizes, spec.name)));
    weights_.emplace(spec.name, core::first_values(spec, table, bound, seed));
  }
  core::make_trainable(weights_, device);
}

CeNetwork::CeNetwork(const Sizes& sizes, const features::TensorFile& file, c10::Device device)
    : sizes_(sizes),
      weights_(
          core::read_weights(file, array_specs(sizes), [](std::string_view) { return false; })),
      device_(device) {
  core::make_trainable(weights_, device);
}

const at::Tensor& CeNetwork::weight(std::string_view name) const {
  return core::weight_of(weights_, name);
}

at::Tensor CeNetwork::read(std::span<const std::vector<std::int64_t>> instructions) const {
  std::vector<std::size_t> order(instructions.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, std::ranges::greater{},
                           [&](std::size_t i) { return instructions[i].size(); });
  const std::int64_t n = std::ssize(order), longest = std::ssize(instructions[order.front()]);
  const at::Tensor ids = at::zeros({n, longest}, at::kLong);
  const at::Tensor lengths = at::empty({n}, at::kLong), back = at::empty({n}, at::kLong);
  for (std::int64_t row = 0; row < n; ++row) {
    const std::size_t from = order[static_cast<std::size_t>(row)];
    std::ranges::copy(instructions[from], ids.data_ptr<std::int64_t>() + row * longest);
    lengths.data_ptr<std::int64_t>()[row] = std::ssize(instructions[from]);
    back.data_ptr<std::int64_t>()[from] = row;
  }
  const at::Tensor words = at::embedding(weight(kWords), ids.to(device_), 0);
  return core::read_rows(weights_, "instruction.lstm", false, words, lengths)
      .hidden[0]
      .index_select(0, back.to(device_));
}

at::Tensor CeNetwork::begin(std::int64_t n) const {
  return at::zeros({n, whole(sizes_.own.hidden)}, at::TensorOptions(at::kFloat).device(device_));
}

at::Tensor CeNetwork::walk(const at::Tensor& sentences, const Steps& steps,
                           const at::Tensor& before) const {
  std::vector<std::int64_t> walks;
  for (const std::int64_t count : steps.counts) {
    for (std::int64_t w = 0; w < count; ++w) walks.push_back(w);
  }
  const at::Tensor of_walk = at::tensor(walks, at::kLong).to(device_);
  const auto linear = [this](const std::string& name, const at::Tensor& x) {
    return at::addmm(weight(name + ".bias"), x, weight(name + ".weight").t());
  };
  const at::Tensor x = at::cat(
      {sentences.index_select(0, of_walk), at::relu(linear("picture", steps.pictures.to(device_))),
       at::relu(linear("depth", steps.depth.to(device_))),
       at::embedding(weight(kActions), steps.previous.to(device_))},
      1);
  return read_gru(x, steps.counts, before,
                  {weight("gru.weight_ih_l0"), weight("gru.weight_hh_l0"), weight("gru.bias_ih_l0"),
                   weight("gru.bias_hh_l0")});
}

at::Tensor CeNetwork::score(const at::Tensor& states) const {
  return at::addmm(weight("choice.bias"), states, weight("choice.weight").t());
}

at::Tensor inflection_loss(const at::Tensor& scores, const at::Tensor& teacher,
                           const std::vector<std::int64_t>& counts, double inflection) {
  const std::span<const std::int64_t> choices(teacher.data_ptr<std::int64_t>(),
                                              static_cast<std::size_t>(teacher.numel()));
  const std::size_t walks = static_cast<std::size_t>(counts.front());
  std::vector<float> weights;
  std::vector<std::size_t> walk_of;
  std::vector<double> sums(walks, 0);
  std::vector<std::int64_t> last(walks, -1);
  for (const std::int64_t count : counts) {
    for (std::size_t w = 0; w < static_cast<std::size_t>(count); ++w) {
      const std::int64_t choice = choices[weights.size()];
      const double weight = choice == last[w] ? 1 : inflection;
      last[w] = choice;
      sums[w] += weight;
      weights.push_back(static_cast<float>(weight));
      walk_of.push_back(w);
    }
  }
  for (std::size_t row = 0; row < weights.size(); ++row) {
    weights[row] /= static_cast<float>(sums[walk_of[row]] * static_cast<double>(walks));
  }
  const at::Tensor there = teacher.to(scores.device());
  const at::Tensor losses = -at::log_softmax(scores, 1).gather(1, there.unsqueeze(1)).squeeze(1);
  return (losses * at::tensor(weights).to(scores.device())).sum();
}

}  // namespace enfilade::neural::continuous
