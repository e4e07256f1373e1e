#include "enfilade/neural/seq2seq/action_decoder.h"

#include <algorithm>

namespace enfilade::neural::seq2seq {
namespace {

std::size_t as_size(std::int64_t n) { return static_cast<std::size_t>(n); }

}  // namespace

ActionDecoder::ActionDecoder(const models::NetworkConfig& config, const Parameters& parameters,
                             const Kernels& kernels)
    : parameters_(parameters),
      kernels_(kernels),
      hidden_(static_cast<std::int64_t>(config.hidden)),
      inputs_width_(static_cast<std::int64_t>(config.action_embedding +
                                              (config.inputs.vision ? config.features : 0))),
      embedding_(static_cast<std::int64_t>(config.action_embedding)) {}

void ActionDecoder::begin(std::int64_t n, std::int64_t steps, bool keep, const Dropout& dropout) {
  const auto options = parameters_.flat_weights.options();
  n_ = n;
  slots_ = keep ? steps : 1;
  dropout_ = dropout;
  seen_ = seen_memory_.get({slots_, n, inputs_width_}, options);
  gates_ = gates_memory_.get({slots_, n, 4 * hidden_}, options);
  outputs_ = outputs_memory_.get({slots_ + 1, n, hidden_}, options);
  cells_ = cells_memory_.get({slots_ + 1, n, hidden_}, options);
  both_ = both_memory_.get({slots_, n, 2 * hidden_}, options);
  query_ = query_memory_.get({slots_, n, hidden_}, options);
  attended_ = attended_memory_.get({slots_, n, hidden_}, options);
  logits_ = logits_memory_.get({slots_, n, kSixActionCount}, options);
  bias_ = parameters_.weight(Weight::kDecoderInputBias) +
          parameters_.weight(Weight::kDecoderHiddenBias);
  inputs_.resize(as_size(steps * n));
  rows_.resize(as_size(steps * n));
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    rows_[i] = {static_cast<std::uint32_t>(i / as_size(n)),
                static_cast<std::uint32_t>(i % as_size(n))};
  }
}

Masks ActionDecoder::masks(Site site, std::int64_t first, std::int64_t count) const {
  return {dropout_, site, std::span(rows_).subspan(as_size(first * n_), as_size(count * n_))};
}

// Without vision the columns of the features are not used.
at::Tensor ActionDecoder::input_weight() const {
  return parameters_.weight(Weight::kDecoderInput).narrow(1, 0, inputs_width_);
}

void ActionDecoder::put_inputs(std::int64_t step, std::span<const std::int32_t> inputs,
                               const at::Tensor& features) {
  const auto begin = inputs_.begin() + step * n_;
  std::copy(inputs.begin(), inputs.end(), begin);
  const at::Tensor seen = seen_.select(0, slot(step));
  kernels_.move_rows(parameters_.weight(Weight::kActionEmbedding), RowList(begin, begin + n_),
                     seen.narrow(1, 0, embedding_), {}, masks(Site::kActions, step, 1));
  if (!features.defined()) return;
  kernels_.move_rows(features, {}, seen.narrow(1, embedding_, inputs_width_ - embedding_), {},
                     masks(Site::kFeatures, step, 1));
}

void ActionDecoder::multiply_inputs(std::int64_t first, std::int64_t count) {
  multiply(flat(seen_, first, count), input_weight().t(), flat(gates_, first, count));
}

void ActionDecoder::recur(std::int64_t step) {
  const std::int64_t before = step % (slots_ + 1), after = (step + 1) % (slots_ + 1);
  const at::Tensor gates = gates_.select(0, slot(step));
  multiply_add(outputs_.select(0, before), parameters_.weight(Weight::kDecoderHidden).t(), gates);
  kernels_.lstm_forward(gates, bias_, cells_.select(0, before), cells_.select(0, after),
                        outputs_.select(0, after));
}

at::Tensor ActionDecoder::attend(const Context& context, std::int64_t first, std::int64_t count) {
  const auto options = parameters_.flat_weights.options();
  weights_ = weights_memory_.get({slots_, n_, context.words.size(1)}, options);
  const at::Tensor outputs =
      outputs_.narrow(0, (first + 1) % (slots_ + 1), count).view({count * n_, hidden_});
  const at::Tensor both = flat(both_, first, count);
  const at::Tensor dropped = both.narrow(1, hidden_, hidden_);
  const at::Tensor query = flat(query_, first, count), attended = flat(attended_, first, count);
  kernels_.move_rows(outputs, {}, dropped, {}, masks(Site::kAttention, first, count));
  multiply(dropped, parameters_.weight(Weight::kAttentionIn).t(), query);
  kernels_.attend(context, query_.narrow(0, slot(first), count),
                  weights_.narrow(0, slot(first), count),
                  both_.narrow(0, slot(first), count).narrow(2, 0, hidden_));
  multiply(both, parameters_.weight(Weight::kAttentionOut).t(), attended);
  kernels_.tanh(attended);
  at::Tensor logits = flat(logits_, first, count);
  multiply(attended, parameters_.weight(Weight::kAction).t(), logits);
  kernels_.add_bias(logits, parameters_.weight(Weight::kActionBias));
  return logits;
}

at::Tensor ActionDecoder::attention(std::int64_t step) const {
  return weights_.select(0, slot(step));
}

ActionDecoder::Gradients ActionDecoder::backward(const Context& context,
                                                 const at::Tensor& logit_gradient) {
  const auto options = parameters_.flat_weights.options();
  const std::int64_t rows = logit_gradient.size(0), steps = rows / n_;
  const at::Tensor attended = flat(attended_, 0, steps);
  const at::Tensor hidden_gradient = hidden_gradient_memory_.get({rows, hidden_}, options);
  const at::Tensor both_gradient = both_gradient_memory_.get({rows, 2 * hidden_}, options);
  const at::Tensor context_gradient = context_gradient_memory_.get(context.words.sizes(), options);
  multiply(logit_gradient.t(), attended, parameters_.gradient(Weight::kAction));
  kernels_.column_sums(logit_gradient, parameters_.gradient(Weight::kActionBias));
  multiply(logit_gradient, parameters_.weight(Weight::kAction), hidden_gradient);
  kernels_.tanh_backward(attended, hidden_gradient);
  attention_backward(context, steps, hidden_gradient, both_gradient, context_gradient);

  const at::Tensor from_next = next_memory_.get({n_, hidden_}, options);
  const at::Tensor cells = cell_gradient_memory_.get({n_, hidden_}, options);
  kernels_.clear(from_next);
  kernels_.clear(cells);
  for (std::int64_t t = steps - 1; t >= 0; --t) {
    const at::Tensor gates = gates_.select(0, t);
    kernels_.lstm_backward(gates, cells_.select(0, t), cells_.select(0, t + 1),
                           both_gradient.narrow(0, t * n_, n_).narrow(1, hidden_, hidden_),
                           from_next, cells);
    multiply(gates, parameters_.weight(Weight::kDecoderHidden), from_next);
  }
  gather_gradients(steps);
  return {context_gradient, from_next, cells};
}

// For all steps at once: the output of attention is not an input of later steps.
void ActionDecoder::attention_backward(const Context& context, std::int64_t steps,
                                       const at::Tensor& hidden_gradient,
                                       const at::Tensor& both_gradient,
                                       const at::Tensor& context_gradient) {
  const std::int64_t rows = steps * n_;
  const at::Tensor query_gradient =
      query_gradient_memory_.get({rows, hidden_}, hidden_gradient.options());
  multiply(hidden_gradient.t(), flat(both_, 0, steps), parameters_.gradient(Weight::kAttentionOut));
  multiply(hidden_gradient, parameters_.weight(Weight::kAttentionOut), both_gradient);
  kernels_.attend_backward(context, query_.narrow(0, 0, steps), weights_.narrow(0, 0, steps),
                           both_gradient.view({steps, n_, 2 * hidden_}).narrow(2, 0, hidden_),
                           query_gradient.view({steps, n_, hidden_}), context_gradient);
  const at::Tensor dropped = flat(both_, 0, steps).narrow(1, hidden_, hidden_);
  multiply(query_gradient.t(), dropped, parameters_.gradient(Weight::kAttentionIn));
  const at::Tensor dropped_gradient = both_gradient.narrow(1, hidden_, hidden_);
  multiply_add(query_gradient, parameters_.weight(Weight::kAttentionIn), dropped_gradient);
  kernels_.move_rows(dropped_gradient, {}, dropped_gradient, {}, masks(Site::kAttention, 0, steps));
}

void ActionDecoder::gather_gradients(std::int64_t steps) {
  const at::Tensor gates = flat(gates_, 0, steps);
  multiply(gates.t(), flat(seen_, 0, steps),
           parameters_.gradient(Weight::kDecoderInput).narrow(1, 0, inputs_width_));
  multiply(gates.t(), flat(outputs_, 0, steps), parameters_.gradient(Weight::kDecoderHidden));
  kernels_.column_sums(gates, parameters_.gradient(Weight::kDecoderInputBias));
  parameters_.gradient(Weight::kDecoderHiddenBias)
      .copy_(parameters_.gradient(Weight::kDecoderInputBias));
  // The features are not trained: only the gradient of the actions' columns is needed.
  const at::Tensor seen_gradient = embedding_memory_.get({steps * n_, embedding_}, gates.options());
  multiply(gates, input_weight().narrow(1, 0, embedding_), seen_gradient);
  kernels_.move_rows(seen_gradient, {}, seen_gradient, {}, masks(Site::kActions, 0, steps));
  const at::Tensor& embedding = parameters_.gradient(Weight::kActionEmbedding);
  kernels_.clear(embedding);
  kernels_.add_rows(seen_gradient, embedding, std::span(inputs_).first(as_size(steps * n_)));
}

}  // namespace enfilade::neural::seq2seq
