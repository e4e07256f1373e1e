/// \file  Encoder, decoder, choice and loss: rollouts with and without gradients.
#pragma once
#include <ATen/ATen.h>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "enfilade/features/tensor_file.h"
#include "enfilade/neural/core/weights.h"
#include "enfilade/neural/seq2seq/kernels.h"
#include "enfilade/neural/seq2seq/network.h"

namespace enfilade::neural::seq2seq {

enum class Weight : std::uint8_t {
  kWordEmbedding,
  kEncoderInput,
  kEncoderHidden,
  kEncoderInputBias,
  kEncoderHiddenBias,
  kStart,
  kStartBias,
  kActionEmbedding,
  kDecoderInput,
  kDecoderHidden,
  kDecoderInputBias,
  kDecoderHiddenBias,
  kAttentionIn,
  kAttentionOut,
  kAction,
  kActionBias,
};
inline constexpr std::size_t kWeights = 16;

struct WeightInfo {
  const char* name = nullptr;  ///< of this weight in the released code
  std::vector<std::int64_t> shape;
  /// Initial values are uniform within 1/sqrt(inputs) of 0; if this is 0, normal.
  std::int64_t inputs = 0;
  std::int64_t begin = 0;  ///< index in the flat arrays
  std::int64_t elements = 0;
};

/// The flat arrays. Weights begin at aligned positions; gaps between them are zero.
class Parameters {
 public:
  Parameters(const models::NetworkConfig& config, const at::TensorOptions& options);

  /// Sets the weights to random numbers that follow from `seed`, the same on every device, with
  /// PyTorch's distributions. Embeddings are normal (row 0 of the words, PAD, is zero), LSTM
  /// weights uniform within 1/sqrt(hidden) of 0, linear weights within 1/sqrt(inputs). Gradients
  /// and moments become 0.
  void initialise(std::uint64_t seed);

  const std::array<WeightInfo, kWeights>& infos() const noexcept { return infos_; }
  const at::Tensor& weight(Weight which) const { return weights_[index(which)]; }
  const at::Tensor& gradient(Weight which) const { return gradients_[index(which)]; }
  /// A part of a flat array, in the shape of weight i.
  at::Tensor view(const at::Tensor& flat, std::size_t i) const;

  at::Tensor flat_weights, flat_gradients, first, second;
  std::uint64_t updates = 0;

 private:
  static std::size_t index(Weight which) { return static_cast<std::size_t>(which); }

  std::array<WeightInfo, kWeights> infos_;
  std::array<at::Tensor, kWeights> weights_, gradients_;
};

/// Words are packed by position and, within a position, by decreasing length of their instruction.
/// So the instructions that continue are the first rows of the previous position.
struct Sentences {
  std::size_t size = 0;               ///< n instructions
  std::int64_t longest = 0;           ///< words
  std::vector<std::int64_t> lengths;  ///< (n) in the caller's order
  std::vector<std::int64_t> order;    ///< (n) the caller's row of each sorted row
  std::vector<std::int64_t> begin;    ///< (longest + 1) first packed word of a position
  std::vector<std::int64_t> words;    ///< packed: ids
  std::vector<MaskRow> masks;         ///< packed: (position, caller's row)
  std::vector<std::int64_t> places;   ///< packed: row * longest + position
  std::vector<std::int64_t>
      before;  ///< of packed words from position 1 on: the previous word of the row
  std::vector<std::int64_t> last;  ///< (n) in the caller's order: the row's last packed word

  std::int64_t rows(std::int64_t position) const {
    const auto p = static_cast<std::size_t>(position);
    return begin[p + 1] - begin[p];
  }
};

/// Packs a batch. Without language every instruction is just <EOS>, which gives the decoder no
/// information.
/// \throws ArgumentError for sizes that do not fit, an id outside the vocabulary, an instruction
/// without a word
Sentences lay_out(const InstructionBatch& batch, const models::NetworkConfig& config);

/// Grows when needed, so a rollout gets no new pages from the system. Its content after get() is
/// undefined.
class Buffer {
 public:
  at::Tensor get(at::IntArrayRef shape, const at::TensorOptions& options) {
    std::int64_t needed = 1;
    for (const std::int64_t n : shape) needed *= n;
    if (!storage_.defined() || storage_.numel() < needed) storage_ = at::empty({needed}, options);
    return storage_.narrow(0, 0, needed).view(shape);
  }

 private:
  at::Tensor storage_;
};

/// Forward and backward pass of one batch at a time; keeps what the backward pass needs.
class SentenceEncoder {
 public:
  SentenceEncoder(const Parameters& parameters, const NetworkKernels& kernels)
      : parameters_(parameters), kernels_(kernels) {}

  /// \param sentences must live until backward() \param start,cells (n, h) written: the
  /// decoder's initial state. The context is valid until the next call.
  SentenceContext forward(const Sentences& sentences, const RolloutDropout& dropout,
                          const at::Tensor& start, const at::Tensor& cells);

  /// \param context_gradient (n, longest, h) \param start_gradient,cell_gradient (n, h), of what
  /// forward() wrote; start_gradient is overwritten. Fills the encoder's gradients.
  void backward(const Sentences& sentences, const RolloutDropout& dropout,
                const at::Tensor& context_gradient, const at::Tensor& start,
                const at::Tensor& start_gradient, const at::Tensor& cell_gradient);

 private:
  void begin_backward(const Sentences& sentences, const at::Tensor& start,
                      const at::Tensor& start_gradient, const at::Tensor& cell_gradient);
  void steps_backward(const Sentences& sentences);
  void gather_gradients(const Sentences& sentences, const RolloutDropout& dropout);
  at::Tensor previous_cells(const Sentences& sentences, std::int64_t position) const;

  const Parameters& parameters_;
  const NetworkKernels& kernels_;
  // Packed, except last_, from_next_ and cell_gradient_: (n, h), the latter two sorted by length.
  at::Tensor words_, gates_, outputs_, cells_, last_, zeros_;
  at::Tensor output_gradient_, from_next_, cell_gradient_;
  Buffer words_memory_, gates_memory_, outputs_memory_, cells_memory_, last_memory_;
  Buffer context_memory_, gradient_memory_, next_memory_, cell_memory_, before_memory_;
};

/// Forward and backward pass of one rollout at a time. Each part of the forward pass takes a range
/// of steps. Values that do not depend on an action are computed for all steps in one product.
class ActionDecoder {
 public:
  ActionDecoder(const models::NetworkConfig& config, const Parameters& parameters,
                const NetworkKernels& kernels);

  /// Begins a rollout of n rows and at most `steps` steps.
  /// \param keep values of all steps, for ranges and backward(), not only of the last
  void begin(std::int64_t n, std::int64_t steps, bool keep, const RolloutDropout& dropout);
  at::Tensor start() const { return outputs_.select(0, 0); }  ///< (n, h), filled by the caller
  at::Tensor start_cells() const { return cells_.select(0, 0); }

  /// \param inputs (n) last actions \param features (n, features), undefined without vision
  void put_inputs(std::int64_t step, std::span<const std::int32_t> inputs,
                  const at::Tensor& features);
  /// Adds the inputs' part of the gates, for steps first .. first + count - 1.
  void multiply_inputs(std::int64_t first, std::int64_t count);
  void recur(std::int64_t step);
  /// Attention and logits (count * n, 6).
  at::Tensor attend(const SentenceContext& context, std::int64_t first, std::int64_t count);
  at::Tensor attention(std::int64_t step) const;  ///< (n, words)

  struct Gradients {
    at::Tensor context, start, cells;
  };
  /// Fills the decoder's gradients. \param logit_gradient (steps * n, 6) of all steps
  Gradients backward(const SentenceContext& context, const at::Tensor& logit_gradient);

 private:
  std::int64_t slot(std::int64_t step) const { return step % slots_; }
  at::Tensor flat(const at::Tensor& x, std::int64_t first, std::int64_t count) const {
    return x.narrow(0, slot(first), count).view({count * n_, x.size(2)});
  }
  at::Tensor input_weight() const;
  Masks masks(DropoutSite site, std::int64_t first, std::int64_t count) const;
  void attention_backward(const SentenceContext& context, std::int64_t steps,
                          const at::Tensor& hidden_gradient, const at::Tensor& both_gradient,
                          const at::Tensor& context_gradient);
  void gather_gradients(std::int64_t steps);

  const Parameters& parameters_;
  const NetworkKernels& kernels_;
  std::int64_t hidden_, inputs_width_, embedding_;
  std::int64_t n_ = 0, slots_ = 0;
  RolloutDropout dropout_;
  std::vector<MaskRow> rows_;         // (steps, n)
  std::vector<std::int64_t> inputs_;  // (steps, n) actions
  at::Tensor bias_;
  // (slots, n, ...); outputs_ and cells_ have a slot more, the start's. both_: mixed words beside
  // the dropped output.
  at::Tensor seen_, gates_, outputs_, cells_, both_, query_, weights_, attended_, logits_;
  Buffer seen_memory_, gates_memory_, outputs_memory_, cells_memory_, both_memory_, query_memory_;
  Buffer weights_memory_, attended_memory_, logits_memory_;
  Buffer hidden_gradient_memory_, both_gradient_memory_, query_gradient_memory_;
  Buffer context_gradient_memory_, next_memory_, cell_gradient_memory_, embedding_memory_;
};

inline constexpr auto kLogits = static_cast<std::size_t>(kSixActionCount);  ///< numbers a row

/// One step of n rows.
struct Choices {
  std::span<double> logits;                    ///< (n, 6); loss() sets -inf where forward is closed
  std::span<const std::uint8_t> forward_open;  ///< (n)
  std::span<const std::int32_t> labels;        ///< (n), or empty without a teacher
};

/// \throws ArgumentError for a label out of range, or forward where that is closed
void check_labels(const Choices& step);

/// Sets logits to -inf where forward is closed. Returns the cross-entropy averaged over the rows
/// with a label (0 without labels).
/// \param gradient (n, 6) of the loss, or empty
double loss(const Choices& step, std::span<double> gradient);

/// Chooses actions, which are also the network's next inputs. With a teacher they are the labels,
/// and kIgnoreInput for rows without one. \pre loss() was called
void choose(const Choices& step, const RolloutOptions& options, std::size_t step_number,
            std::span<std::int32_t> actions);

enum class WithGradients : std::uint8_t { kNo, kYes };

/// The attentional LSTM sequence-to-sequence network of the paper (section 4.3): its parameters,
/// their gradients and moments, on one device. One thread at a time; it computes on the threads of
/// set_threads(). The same calls give the same bits with the same number of threads. With another
/// number results differ as the BLAS's do (OpenBLAS: by up to 1e-6 of the largest gradient).
class Network {
 public:
  /// Random weights by `seed`, from the distributions with which PyTorch initialises its modules.
  /// \throws ArgumentError as validate(); Error for a device that is not available
  Network(const models::NetworkConfig& config, std::uint64_t seed,
          const std::string& device = "cpu");
  /// Of any type, on any device; its weights are zeros.
  Network(const models::NetworkConfig& config, const at::TensorOptions& options,
          std::unique_ptr<NetworkKernels> kernels);
  Network(const Network&) = delete;  // the parts refer to each other
  Network& operator=(const Network&) = delete;

  const models::NetworkConfig& config() const noexcept { return config_; }
  Parameters& parameters() noexcept { return parameters_; }

  /// Computes a rollout of the batch to its end or max_steps, without gradients. With kTeacher and
  /// no observer the whole trajectory is made before the network runs, as the labels do not depend
  /// on it.
  /// \throws ArgumentError for sizes that do not fit, kTeacher or a loss without a teacher
  RolloutResult rollout(const InstructionBatch& instructions, Environment& environment,
                        const RolloutOptions& options, const StepObserver& observer = {}) {
    return rollout(instructions, environment, options, WithGradients::kNo, observer);
  }
  /// The same with gradients, which replace the previous ones. Sampling an action has no gradient.
  /// \param decoder_done called when the gradients of the decoder are complete, and only those
  RolloutResult rollout_with_gradients(const InstructionBatch& instructions,
                                       Environment& environment, const RolloutOptions& options,
                                       const std::function<void()>& decoder_done = {}) {
    return rollout(instructions, environment, options, WithGradients::kYes, {}, decoder_done);
  }
  /// Either of them.
  RolloutResult rollout(const InstructionBatch& instructions, Environment& environment,
                        const RolloutOptions& options, WithGradients with_gradients,
                        const StepObserver& observer = {},
                        const std::function<void()>& decoder_done = {});
  /// Begins a greedy rollout that the caller steps: n instructions, then at most max_steps calls of
  /// act(). Each gives the n most likely actions. No other rollout may come between.
  /// \throws ArgumentError for sizes that do not fit
  void begin(const InstructionBatch& instructions, std::size_t max_steps);
  /// One step of the rollout that begin() began.
  /// \param features (n, config().features) \param forward_open (n) \param actions (n), 0..5
  /// \throws ArgumentError for sizes that do not fit, or without begin()
  void act(std::span<const float> features, std::span<const std::uint8_t> forward_open,
           std::span<std::int32_t> actions);

  /// One Adam update of all parameters from the gradients. \throws Error naming a gradient that is
  /// not finite; then nothing has changed
  void update(const models::AdamConfig& config);
  std::uint64_t updates() const noexcept { return parameters_.updates; }  ///< so far

  /// Copies of arrays, with the names of the released PyTorch code ("encoder.embedding.weight",
  /// "decoder.lstm.weight_ih", ...) and, for training, "adam.first.<name>" and so on.
  using State = core::SavedState;
  State weights() const;         ///< the parameters
  State gradients() const;       ///< of the last rollout_with_gradients()
  State training_state() const;  ///< parameters, moments and number of updates
  /// Loads what weights() or training_state() gave.
  /// \throws InvalidInput naming every missing, surplus and wrong-shaped array of the file
  void load_weights(const features::TensorFile& file);
  /// \throws as load_weights()
  void load_training_state(const features::TensorFile& file);

 private:
  /// Host memory of a rollout; labels and forward_open are kept for all steps.
  struct RolloutMemory {
    std::size_t n = 0, steps = 0;
    bool labelled = false;
    std::vector<std::int32_t> inputs, actions;  ///< (n)
    std::vector<std::uint8_t> forward_open;     ///< (steps, n)
    std::vector<std::int32_t> labels;           ///< (steps, n), empty without a teacher
    std::vector<float> features;                ///< (n, dimensions) as the environment gives them
    std::vector<double> logits;                 ///< (n, 6)
    std::vector<double> gradient;               ///< (steps, n, 6), empty without gradients
    std::chrono::steady_clock::duration environment{};  ///< time of its observations and steps

    Choices choices(std::size_t step);
    std::span<double> gradient_of(std::size_t step);
    void read(const at::Tensor& step_logits);
  };

  /// State between begin() and act(). The context points into the sentences.
  struct Begun {
    Sentences sentences;
    SentenceContext context;
    std::size_t steps = 0, max_steps = 0;
  };

  void check(const InstructionBatch& instructions, const Environment& environment,
             const RolloutOptions& options, WithGradients with_gradients) const;
  void begin_rollout(const Environment& environment, const RolloutOptions& options,
                     WithGradients with_gradients);
  void observe(Environment& environment, std::size_t step);
  bool move(Environment& environment);  ///< the actions; whether an episode goes on
  void put_inputs(std::size_t step);
  void advance(const SentenceContext& context,
               std::size_t step);  ///< from inputs to memory_.logits
  RolloutResult run(const SentenceContext& context, Environment& environment,
                    const RolloutOptions& options, const StepObserver& observer);
  RolloutResult rollout_as_taught(const SentenceContext& context, Environment& environment,
                                  const RolloutOptions& options);
  void backward(const Sentences& sentences, const SentenceContext& context,
                const RolloutDropout& dropout, std::size_t steps,
                const std::function<void()>& decoder_done);
  void tell(const StepObserver& observer, std::size_t step) const;

  models::NetworkConfig config_;
  std::unique_ptr<NetworkKernels> kernels_;
  Parameters parameters_;
  SentenceEncoder encoder_;
  ActionDecoder decoder_;
  RolloutMemory memory_;
  std::optional<Begun> begun_;
};

}  // namespace enfilade::neural::seq2seq
