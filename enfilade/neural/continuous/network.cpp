#include "enfilade/neural/continuous/network.h"

#include <ATen/ATen.h>
#include <torch/csrc/autograd/custom_function.h>
#include <algorithm>
#include <numeric>
#include <string>

namespace enfilade::neural::continuous {
namespace {

using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

// Where each step's rows begin, and behind the last the number of all rows.
std::vector<std::int64_t> beginnings(const std::vector<std::int64_t>& counts) {
  std::vector<std::int64_t> first{0};
  for (const std::int64_t count : counts) first.push_back(first.back() + count);
  return first;
}

// The part of one gate: 0 reset, 1 update, 2 new.
at::Tensor gate(const at::Tensor& gates, std::int64_t which) {
  const std::int64_t hidden = gates.size(1) / 3;
  return gates.narrow(1, which * hidden, hidden);
}

// The states before the steps of rows `first` and on; \pre step > 0
at::Tensor states_before(const at::Tensor& states, const std::vector<std::int64_t>& first,
                         std::size_t step, std::int64_t rows) {
  return states.narrow(0, first[step - 1], rows);
}

class Gru : public torch::autograd::Function<Gru> {
 public:
  static at::Tensor forward(AutogradContext* context, const at::Tensor& x, const at::Tensor& input,
                            const at::Tensor& hidden, const at::Tensor& input_bias,
                            const at::Tensor& hidden_bias, const at::Tensor& before,
                            const std::vector<std::int64_t>& counts) {
    const std::vector<std::int64_t> first = beginnings(counts);
    const at::Tensor gates = at::addmm(input_bias, x, input.t());
    at::Tensor states = at::empty({x.size(0), hidden.size(1)}, gates.options());
    const at::Tensor own_new = at::empty_like(states);  // the state's part of the new gate
    for (std::size_t t = 0; t < counts.size(); ++t) {
      const std::int64_t rows = counts[t];
      const at::Tensor last = t == 0 ? before : states_before(states, first, t, rows);
      const at::Tensor own = at::addmm(hidden_bias, last, hidden.t());
      const at::Tensor now = gates.narrow(0, first[t], rows);
      at::Tensor reset = gate(now, 0), update = gate(now, 1), fresh = gate(now, 2);
      reset.add_(gate(own, 0)).sigmoid_();
      update.add_(gate(own, 1)).sigmoid_();
      own_new.narrow(0, first[t], rows).copy_(gate(own, 2));
      fresh.addcmul_(reset, gate(own, 2)).tanh_();
      at::Tensor state = states.narrow(0, first[t], rows);
      at::sub_out(state, last, fresh).mul_(update).add_(fresh);
    }
    context->save_for_backward({x, input, hidden, before, gates, states, own_new});
    context->saved_data["counts"] = counts;
    return states;
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients) {
    const variable_list saved = context->get_saved_variables();
    const at::Tensor &x = saved[0], &input = saved[1], &hidden = saved[2], &before = saved[3],
                     &gates = saved[4], &states = saved[5], &own_new = saved[6];
    const std::vector<std::int64_t> counts = context->saved_data["counts"].toIntVector();
    const std::vector<std::int64_t> first = beginnings(counts);
    const at::Tensor to_gates = at::empty_like(gates), to_own = at::empty_like(gates);
    const at::Tensor lasts = at::empty_like(states);
    const at::Tensor carried = at::zeros_like(before);  // from each row's next step
    for (std::size_t t = counts.size(); t-- > 0;) {
      const std::int64_t rows = counts[t];
      const at::Tensor last = t == 0 ? before : states_before(states, first, t, rows);
      lasts.narrow(0, first[t], rows).copy_(last);
      const at::Tensor now = gates.narrow(0, first[t], rows);
      const at::Tensor reset = gate(now, 0), update = gate(now, 1), fresh = gate(now, 2);
      const at::Tensor own = own_new.narrow(0, first[t], rows);
      const at::Tensor to_state =
          gradients[0].narrow(0, first[t], rows) + carried.narrow(0, 0, rows);
      const at::Tensor to_fresh = to_state * (1 - update) * (1 - fresh * fresh);
      const at::Tensor to_update = to_state * (last - fresh) * update * (1 - update);
      const at::Tensor to_reset = to_fresh * own * reset * (1 - reset);
      const at::Tensor down = to_gates.narrow(0, first[t], rows);
      const at::Tensor down_own = to_own.narrow(0, first[t], rows);
      for (const at::Tensor& part : {down, down_own}) {
        gate(part, 0).copy_(to_reset);
        gate(part, 1).copy_(to_update);
      }
      gate(down, 2).copy_(to_fresh);
      gate(down_own, 2).copy_(to_fresh * reset);
      at::Tensor next = carried.narrow(0, 0, rows);
      next.copy_(to_state * update).addmm_(down_own, hidden);
    }
    const at::Tensor to_x = context->needs_input_grad(0) ? at::mm(to_gates, input) : at::Tensor();
    return {to_x,
            at::mm(to_gates.t(), x),
            at::mm(to_own.t(), lasts),
            to_gates.sum(0),
            to_own.sum(0),
            {},
            {}};
  }
};

using core::ArraySpec;

constexpr const char* kWords = "instruction.embedding.weight";
constexpr const char* kActions = "action_embedding.weight";
constexpr std::size_t kBeginAndMask = 2;

std::int64_t whole(std::size_t size) { return static_cast<std::int64_t>(size); }

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
  core::add_layer(specs, "picture", {whole(own.picture), picture_inputs(sizes)});
  core::add_layer(specs, "depth", {whole(own.depth), kDepthSize});
  specs.push_back({kActions, {1 + kChoices, whole(own.action_embedding)}});
  const std::int64_t in = whole(own.sentence + own.picture + own.depth + own.action_embedding);
  specs.push_back({"gru.weight_ih_l0", {3 * hidden, in}});
  specs.push_back({"gru.weight_hh_l0", {3 * hidden, hidden}});
  specs.push_back({"gru.bias_ih_l0", {3 * hidden}});
  specs.push_back({"gru.bias_hh_l0", {3 * hidden}});
  core::add_layer(specs, "choice", {kChoices, hidden});
  return specs;
}

// PyTorch draws uniformly within +-1 / sqrt(of this): of recurrent layers their size, of linear
// ones their inputs. 0: a table of words or actions.
std::int64_t fan_of(const Sizes& sizes, const std::string& name) {
  if (name == kWords || name == kActions) return 0;
  if (name.starts_with("instruction.lstm.")) return whole(sizes.own.sentence);
  if (name.starts_with("picture.")) return picture_inputs(sizes);
  if (name.starts_with("depth.")) return kDepthSize;
  return whole(sizes.own.hidden);
}

}  // namespace

at::Tensor read_gru(const at::Tensor& x, const std::vector<std::int64_t>& counts,
                    const at::Tensor& before, const GruWeights& weights) {
  return Gru::apply(x, weights.input, weights.hidden, weights.input_bias, weights.hidden_bias,
                    before, counts);
}

Sizes sizes_of(const models::TrainConfig& config) {
  return {whole(config.network.vocabulary + kBeginAndMask), whole(config.network.features),
          config.seq2seq_ce};
}

CeNetwork::CeNetwork(const Sizes& sizes, std::uint64_t seed, c10::Device device)
    : LstmNetwork(
          array_specs(sizes), [&](const ArraySpec& spec) { return fan_of(sizes, spec.name); }, seed,
          device),
      sizes_(sizes) {}

CeNetwork::CeNetwork(const Sizes& sizes, const features::TensorFile& file, c10::Device device)
    : LstmNetwork(array_specs(sizes), file, device), sizes_(sizes) {}

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
  const at::Tensor words = at::embedding(weight(kWords), ids.to(device()), 0);
  return core::read_rows(weights(), "instruction.lstm", false, words, lengths)
      .hidden[0]
      .index_select(0, back.to(device()));
}

at::Tensor CeNetwork::begin(std::int64_t n) const {
  return at::zeros({n, whole(sizes_.own.hidden)}, at::TensorOptions(at::kFloat).device(device()));
}

at::Tensor CeNetwork::walk(const at::Tensor& sentences, const StepRows& steps,
                           const at::Tensor& before) const {
  std::vector<std::int64_t> walks;
  for (const std::int64_t count : steps.counts) {
    for (std::int64_t w = 0; w < count; ++w) walks.push_back(w);
  }
  const at::Tensor of_walk = at::tensor(walks, at::kLong).to(device());
  const auto linear = [this](const std::string& name, const at::Tensor& x) {
    return at::addmm(weight(name + ".bias"), x, weight(name + ".weight").t());
  };
  const at::Tensor x = at::cat(
      {sentences.index_select(0, of_walk), at::relu(linear("picture", steps.pictures.to(device()))),
       at::relu(linear("depth", steps.depth.to(device()))),
       at::embedding(weight(kActions), steps.previous.to(device()))},
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
