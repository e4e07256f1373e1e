#include "enfilade/neural/continuous/gru.h"

#include <ATen/ATen.h>
#include <torch/csrc/autograd/custom_function.h>

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
    const at::Tensor states = at::empty({x.size(0), hidden.size(1)}, gates.options());
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

}  // namespace

at::Tensor read_gru(const at::Tensor& x, const std::vector<std::int64_t>& counts,
                    const at::Tensor& before, const GruWeights& weights) {
  return Gru::apply(x, weights.input, weights.hidden, weights.input_bias, weights.hidden_bias,
                    before, counts);
}

}  // namespace enfilade::neural::continuous
