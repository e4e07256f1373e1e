/// \file  Encoder, decoder and loss: rollouts with and without gradients.
#pragma once
#include <ATen/ATen.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "enfilade/neural/seq2seq/action_decoder.h"
#include "enfilade/neural/seq2seq/choice.h"
#include "enfilade/neural/seq2seq/kernels.h"
#include "enfilade/neural/seq2seq/network.h"
#include "enfilade/neural/seq2seq/parameters.h"
#include "enfilade/neural/seq2seq/sentence_encoder.h"
#include "enfilade/neural/seq2seq/sentences.h"

namespace enfilade::neural::seq2seq {

enum class WithGradients : std::uint8_t { kNo, kYes };

/// The implementation of Network, for any type and kernels. Calls need c10::InferenceMode.
class Seq2Seq {
 public:
  /// \param options type and device of all tensors \throws ArgumentError as validate()
  Seq2Seq(const models::NetworkConfig& config, const at::TensorOptions& options,
          std::unique_ptr<Kernels> kernels);
  Seq2Seq(const Seq2Seq&) = delete;  // the parts refer to each other
  Seq2Seq& operator=(const Seq2Seq&) = delete;

  RolloutResult rollout(const InstructionBatch& instructions, Environment& environment,
                        const RolloutOptions& options, WithGradients with_gradients,
                        const StepObserver& observer = {},
                        const std::function<void()>& decoder_done = {});
  /// As Network's.
  void begin(const InstructionBatch& instructions, std::size_t max_steps);
  void act(std::span<const float> features, std::span<const std::uint8_t> forward_open,
           std::span<std::int32_t> actions);
  /// \throws Error naming a gradient that is not finite
  void update(const models::AdamConfig& config);

  const models::NetworkConfig& config() const noexcept { return config_; }
  Parameters& parameters() noexcept { return parameters_; }
  const Parameters& parameters() const noexcept { return parameters_; }

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

    Choices choices(std::size_t step);
    std::span<double> gradient_of(std::size_t step);
    void read(const at::Tensor& step_logits);
  };

  /// State between begin() and act(). The context points into the sentences.
  struct Begun {
    Sentences sentences;
    Context context;
    std::size_t steps = 0, max_steps = 0;
  };

  void check(const InstructionBatch& instructions, const Environment& environment,
             const RolloutOptions& options, WithGradients with_gradients) const;
  void begin_rollout(const Environment& environment, const RolloutOptions& options,
                     WithGradients with_gradients);
  void observe(Environment& environment, std::size_t step);
  void put_inputs(std::size_t step);
  void advance(const Context& context, std::size_t step);  ///< from inputs to memory_.logits
  RolloutResult run(const Context& context, Environment& environment, const RolloutOptions& options,
                    const StepObserver& observer);
  RolloutResult rollout_as_taught(const Context& context, Environment& environment,
                                  const RolloutOptions& options);
  void backward(const Sentences& sentences, const Context& context, const Dropout& dropout,
                std::size_t steps, const std::function<void()>& decoder_done);
  void tell(const StepObserver& observer, std::size_t step) const;

  models::NetworkConfig config_;
  std::unique_ptr<Kernels> kernels_;
  Parameters parameters_;
  SentenceEncoder encoder_;
  ActionDecoder decoder_;
  RolloutMemory memory_;
  std::optional<Begun> begun_;
};

/// Implementation of a network.
Seq2Seq& implementation_of(Network& network);

}  // namespace enfilade::neural::seq2seq
