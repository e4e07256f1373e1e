#include <fmt/format.h>
#include <algorithm>
#include <numeric>

#include "enfilade/core/errors.h"
#include "enfilade/models/instruction_words.h"
#include "enfilade/neural/seq2seq/seq2seq.h"

namespace enfilade::neural::seq2seq {
namespace {

std::size_t as_size(std::int64_t n) { return static_cast<std::size_t>(n); }

void check(const InstructionBatch& batch, const models::NetworkConfig& config) {
  if (batch.tokens.size() != batch.size * config.max_words) {
    throw ArgumentError(fmt::format("instructions: {} ids for {} instructions of {} words",
                                    batch.tokens.size(), batch.size, config.max_words));
  }
  for (std::size_t i = 0; i < batch.tokens.size(); ++i) {
    if (batch.tokens[i] < config.vocabulary) continue;
    throw ArgumentError(fmt::format(
        "instructions: instruction {}, word {}: id {}, the vocabulary has {} words",
        i / config.max_words, i % config.max_words, batch.tokens[i], config.vocabulary));
  }
}

void set_lengths(const InstructionBatch& batch, const models::NetworkConfig& config,
                 Sentences& out) {
  for (std::size_t r = 0; r < batch.size; ++r) {
    const auto row = batch.tokens.subspan(r * config.max_words, config.max_words);
    const auto length =
        static_cast<std::int64_t>(config.inputs.language ? models::word_count(row) : 1);
    if (length == 0) {
      throw ArgumentError(fmt::format(
          "instructions: instruction {} begins with PAD: at least one word is needed", r));
    }
    out.lengths.push_back(length);
    out.longest = std::max(out.longest, length);
  }
}

}  // namespace

ActionDecoder::ActionDecoder(const models::NetworkConfig& config, const Parameters& parameters,
                             const NetworkKernels& kernels)
    : parameters_(parameters),
      kernels_(kernels),
      hidden_(static_cast<std::int64_t>(config.hidden)),
      inputs_width_(static_cast<std::int64_t>(config.action_embedding +
                                              (config.inputs.vision ? config.features : 0))),
      embedding_(static_cast<std::int64_t>(config.action_embedding)) {}

void ActionDecoder::begin(std::int64_t n, std::int64_t steps, bool keep,
                          const RolloutDropout& dropout) {
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

Masks ActionDecoder::masks(DropoutSite site, std::int64_t first, std::int64_t count) const {
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
                     seen.narrow(1, 0, embedding_), {}, masks(DropoutSite::kActions, step, 1));
  if (!features.defined()) return;
  kernels_.move_rows(features, {}, seen.narrow(1, embedding_, inputs_width_ - embedding_), {},
                     masks(DropoutSite::kFeatures, step, 1));
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

at::Tensor ActionDecoder::attend(const SentenceContext& context, std::int64_t first,
                                 std::int64_t count) {
  const auto options = parameters_.flat_weights.options();
  weights_ = weights_memory_.get({slots_, n_, context.words.size(1)}, options);
  const at::Tensor outputs =
      outputs_.narrow(0, (first + 1) % (slots_ + 1), count).view({count * n_, hidden_});
  const at::Tensor both = flat(both_, first, count);
  const at::Tensor dropped = both.narrow(1, hidden_, hidden_);
  const at::Tensor query = flat(query_, first, count), attended = flat(attended_, first, count);
  kernels_.move_rows(outputs, {}, dropped, {}, masks(DropoutSite::kAttention, first, count));
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

ActionDecoder::Gradients ActionDecoder::backward(const SentenceContext& context,
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
void ActionDecoder::attention_backward(const SentenceContext& context, std::int64_t steps,
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
  kernels_.move_rows(dropped_gradient, {}, dropped_gradient, {},
                     masks(DropoutSite::kAttention, 0, steps));
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
  kernels_.move_rows(seen_gradient, {}, seen_gradient, {}, masks(DropoutSite::kActions, 0, steps));
  const at::Tensor& embedding = parameters_.gradient(Weight::kActionEmbedding);
  kernels_.clear(embedding);
  kernels_.add_rows(seen_gradient, embedding, std::span(inputs_).first(as_size(steps * n_)));
}

SentenceContext SentenceEncoder::forward(const Sentences& sentences, const RolloutDropout& dropout,
                                         const at::Tensor& start, const at::Tensor& cells) {
  const at::Tensor& embedding = parameters_.weight(Weight::kWordEmbedding);
  const at::Tensor recurrent = parameters_.weight(Weight::kEncoderHidden).t();
  const auto options = embedding.options();
  const auto n = static_cast<std::int64_t>(sentences.size);
  const auto packed = static_cast<std::int64_t>(sentences.words.size());
  const std::int64_t h = cells.size(1);
  words_ = words_memory_.get({packed, embedding.size(1)}, options);
  gates_ = gates_memory_.get({packed, 4 * h}, options);
  outputs_ = outputs_memory_.get({packed, h}, options);
  cells_ = cells_memory_.get({packed, h}, options);
  if (!zeros_.defined() || zeros_.size(0) < n) zeros_ = at::zeros({n, h}, options);

  kernels_.move_rows(embedding, sentences.words, words_, {},
                     {dropout, DropoutSite::kWords, sentences.masks});
  multiply(words_, parameters_.weight(Weight::kEncoderInput).t(), gates_);
  const at::Tensor bias = parameters_.weight(Weight::kEncoderInputBias) +
                          parameters_.weight(Weight::kEncoderHiddenBias);
  for (std::int64_t p = 0; p < sentences.longest; ++p) {
    const std::int64_t begin = sentences.begin[static_cast<std::size_t>(p)];
    const std::int64_t rows = sentences.rows(p);
    const at::Tensor gates = gates_.narrow(0, begin, rows);
    if (p > 0) {
      const std::int64_t before = sentences.begin[static_cast<std::size_t>(p - 1)];
      multiply_add(outputs_.narrow(0, before, rows), recurrent, gates);
    }
    kernels_.lstm_forward(gates, bias, previous_cells(sentences, p), cells_.narrow(0, begin, rows),
                          outputs_.narrow(0, begin, rows));
  }

  last_ = last_memory_.get({n, h}, options);
  kernels_.move_rows(outputs_, sentences.last, last_, {}, {});
  kernels_.move_rows(cells_, sentences.last, cells, {}, {});
  multiply(last_, parameters_.weight(Weight::kStart).t(), start);
  kernels_.add_bias(start, parameters_.weight(Weight::kStartBias));
  kernels_.tanh(start);

  const at::Tensor context = context_memory_.get({n, sentences.longest, h}, options);
  kernels_.move_rows(outputs_, {}, context.view({n * sentences.longest, h}), sentences.places,
                     {dropout, DropoutSite::kContext, sentences.masks});
  return {context, sentences.lengths};
}

at::Tensor SentenceEncoder::previous_cells(const Sentences& sentences,
                                           std::int64_t position) const {
  const std::int64_t rows = sentences.rows(position);
  if (position == 0) return zeros_.narrow(0, 0, rows);
  return cells_.narrow(0, sentences.begin[static_cast<std::size_t>(position - 1)], rows);
}

void SentenceEncoder::backward(const Sentences& sentences, const RolloutDropout& dropout,
                               const at::Tensor& context_gradient, const at::Tensor& start,
                               const at::Tensor& start_gradient, const at::Tensor& cell_gradient) {
  begin_backward(sentences, start, start_gradient, cell_gradient);
  const std::int64_t h = start.size(1);
  output_gradient_ = gradient_memory_.get({outputs_.size(0), h}, outputs_.options());
  kernels_.move_rows(context_gradient.view({-1, h}), sentences.places, output_gradient_, {},
                     {dropout, DropoutSite::kContext, sentences.masks});
  steps_backward(sentences);
  gather_gradients(sentences, dropout);
}

// Gradients of the last words' outputs and cells, from those of the decoder's initial state. Rows
// are sorted by length: steps_backward() takes each row from its last word on.
void SentenceEncoder::begin_backward(const Sentences& sentences, const at::Tensor& start,
                                     const at::Tensor& start_gradient,
                                     const at::Tensor& cell_gradient) {
  kernels_.tanh_backward(start, start_gradient);
  multiply(start_gradient.t(), last_, parameters_.gradient(Weight::kStart));
  kernels_.column_sums(start_gradient, parameters_.gradient(Weight::kStartBias));
  from_next_ = next_memory_.get(start.sizes(), start.options());
  cell_gradient_ = cell_memory_.get(start.sizes(), start.options());
  // last_ is not needed any more.
  multiply(start_gradient, parameters_.weight(Weight::kStart), last_);
  kernels_.move_rows(last_, sentences.order, from_next_, {}, {});
  kernels_.move_rows(cell_gradient, sentences.order, cell_gradient_, {}, {});
}

void SentenceEncoder::steps_backward(const Sentences& sentences) {
  const at::Tensor& recurrent = parameters_.weight(Weight::kEncoderHidden);
  for (std::int64_t p = sentences.longest - 1; p >= 0; --p) {
    const std::int64_t begin = sentences.begin[static_cast<std::size_t>(p)];
    const std::int64_t rows = sentences.rows(p);
    const at::Tensor gates = gates_.narrow(0, begin, rows);
    const at::Tensor from_next = from_next_.narrow(0, 0, rows);
    kernels_.lstm_backward(gates, previous_cells(sentences, p), cells_.narrow(0, begin, rows),
                           output_gradient_.narrow(0, begin, rows), from_next,
                           cell_gradient_.narrow(0, 0, rows));
    if (p > 0) multiply(gates, recurrent, from_next);
  }
}

void SentenceEncoder::gather_gradients(const Sentences& sentences, const RolloutDropout& dropout) {
  const auto later = static_cast<std::int64_t>(sentences.before.size());
  const at::Tensor& recurrent = parameters_.gradient(Weight::kEncoderHidden);
  if (later > 0) {
    const at::Tensor before = before_memory_.get({later, outputs_.size(1)}, outputs_.options());
    kernels_.move_rows(outputs_, sentences.before, before, {}, {});
    multiply(gates_.narrow(0, gates_.size(0) - later, later).t(), before, recurrent);
  } else {
    kernels_.clear(recurrent);
  }
  multiply(gates_.t(), words_, parameters_.gradient(Weight::kEncoderInput));
  kernels_.column_sums(gates_, parameters_.gradient(Weight::kEncoderInputBias));
  parameters_.gradient(Weight::kEncoderHiddenBias)
      .copy_(parameters_.gradient(Weight::kEncoderInputBias));
  // The words themselves are not needed any more.
  multiply(gates_, parameters_.weight(Weight::kEncoderInput), words_);
  kernels_.move_rows(words_, {}, words_, {}, {dropout, DropoutSite::kWords, sentences.masks});
  const at::Tensor& embedding = parameters_.gradient(Weight::kWordEmbedding);
  kernels_.clear(embedding);
  kernels_.add_rows(words_, embedding, sentences.words);
}

Sentences lay_out(const InstructionBatch& batch, const models::NetworkConfig& config) {
  check(batch, config);
  Sentences out;
  out.size = batch.size;
  set_lengths(batch, config, out);
  out.order.resize(batch.size);
  std::iota(out.order.begin(), out.order.end(), 0);
  const auto length = [&](std::int64_t row) { return out.lengths[static_cast<std::size_t>(row)]; };
  std::stable_sort(out.order.begin(), out.order.end(),
                   [&](std::int64_t a, std::int64_t b) { return length(a) > length(b); });
  out.last.resize(batch.size);
  out.begin.push_back(0);
  for (std::int64_t p = 0; p < out.longest; ++p) {
    for (std::size_t s = 0; s < out.order.size() && length(out.order[s]) > p; ++s) {
      const auto row = static_cast<std::size_t>(out.order[s]);
      const std::size_t place = row * config.max_words + static_cast<std::size_t>(p);
      out.last[row] = static_cast<std::int64_t>(out.words.size());
      out.words.push_back(config.inputs.language ? batch.tokens[place] : tasks::Vocabulary::kEnd);
      out.masks.push_back({static_cast<std::uint32_t>(p), static_cast<std::uint32_t>(row)});
      out.places.push_back(out.order[s] * out.longest + p);
      if (p > 0) {
        const std::int64_t previous = out.begin[static_cast<std::size_t>(p - 1)];
        out.before.push_back(previous + static_cast<std::int64_t>(s));
      }
    }
    out.begin.push_back(static_cast<std::int64_t>(out.words.size()));
  }
  return out;
}

}  // namespace enfilade::neural::seq2seq
