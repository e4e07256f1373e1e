#include "enfilade/neural/seq2seq/sentence_encoder.h"

namespace enfilade::neural::seq2seq {

Context SentenceEncoder::forward(const Sentences& sentences, const Dropout& dropout,
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
                     {dropout, Site::kWords, sentences.masks});
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
                     {dropout, Site::kContext, sentences.masks});
  return {context, sentences.lengths};
}

at::Tensor SentenceEncoder::previous_cells(const Sentences& sentences,
                                           std::int64_t position) const {
  const std::int64_t rows = sentences.rows(position);
  if (position == 0) return zeros_.narrow(0, 0, rows);
  return cells_.narrow(0, sentences.begin[static_cast<std::size_t>(position - 1)], rows);
}

void SentenceEncoder::backward(const Sentences& sentences, const Dropout& dropout,
                               const at::Tensor& context_gradient, const at::Tensor& start,
                               const at::Tensor& start_gradient, const at::Tensor& cell_gradient) {
  begin_backward(sentences, start, start_gradient, cell_gradient);
  const std::int64_t h = start.size(1);
  output_gradient_ = gradient_memory_.get({outputs_.size(0), h}, outputs_.options());
  kernels_.move_rows(context_gradient.view({-1, h}), sentences.places, output_gradient_, {},
                     {dropout, Site::kContext, sentences.masks});
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

void SentenceEncoder::gather_gradients(const Sentences& sentences, const Dropout& dropout) {
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
  kernels_.move_rows(words_, {}, words_, {}, {dropout, Site::kWords, sentences.masks});
  const at::Tensor& embedding = parameters_.gradient(Weight::kWordEmbedding);
  kernels_.clear(embedding);
  kernels_.add_rows(words_, embedding, sentences.words);
}

}  // namespace enfilade::neural::seq2seq
