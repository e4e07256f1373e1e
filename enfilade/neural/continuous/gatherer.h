/// \file  The agent's observation at a step: features of a picture, and a coarse depth picture.
/// DAgger's rollouts: actions of the teacher and the network, with the teacher's at every step.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/agents/continuous_agent.h"
#include "enfilade/continuous/eyes.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/models/instruction_words.h"
#include "enfilade/models/network_config.h"
#include "enfilade/neural/continuous/episode_file.h"
#include "enfilade/neural/continuous/network.h"
#include "enfilade/neural/continuous_agent.h"

namespace enfilade::neural::continuous {

/// Draws and encodes. Pictures are those that the encoder was made for: of `home` 128 x 96, of
/// ResNets VLN-CE's 224 x 224 at 90 degrees. Depth is drawn with 64 x 64 pixels at 90 degrees, cut
/// off at 10 m, of which cells of 4 x 4 keep the mean. One thread at a time.
class SightEncoder {
 public:
  /// \throws ArgumentError without a scene_of; as make_encoder()
  explicit SightEncoder(const ContinuousSight& config);

  /// Source of its features: the encoder, its weights, the camera.
  features::FeatureInfo info() const;
  /// The observations of the episodes `rows` of a batch, one after another.
  /// \param eye_height metres above the feet
  /// \throws as scene_of, Eyes::render()
  SightRows look(std::span<const agents::ContinuousObservation> batch,
                 std::span<const std::size_t> rows, double eye_height);

 private:
  void draw(const std::string& scan, std::span<const enfilade::continuous::MeshView> views,
            std::span<float> pictures, std::span<float> depth);

  ContinuousSight config_;
  std::unique_ptr<ImageEncoder> encoder_;
  Camera camera_;
  enfilade::continuous::EyesCache scenes_;
};

/// The ids of an instruction as the network reads it. An agent that uses no language reads the ids
/// of its two ends alone.
std::vector<std::int64_t> read_text(const models::InstructionWords& words, std::string_view text,
                                    const models::NetworkConfig& config);

/// (n, features) numbers of stored pictures; those of an agent that does not see are zeros.
at::Tensor picture_numbers(std::span<const std::uint16_t> halves, std::int64_t n,
                           const Sizes& sizes);
/// (n, kDepthSize) likewise, from 0 to 1.
at::Tensor depth_numbers(std::span<const std::uint8_t> bytes, std::int64_t n);

/// By slot: the sentence's state, the GRU's, and the last action. No gradients. One thread at a
/// time.
class EpisodeStates {
 public:
  /// \param network outlives *this
  explicit EpisodeStates(const CeNetwork& network) : network_(network) {}

  /// A new episode begins in a slot. \param instruction its ids
  void start(std::size_t slot, const std::vector<std::int64_t>& instruction);
  /// Goes one step on in some slots. \param seen there, in their order; empty: nothing
  /// \return (slots, kChoices) probabilities of the choices
  at::Tensor step(std::span<const std::size_t> slots, const SightRows& seen);
  /// The likeliest choices instead of their probabilities.
  std::vector<std::int64_t> likeliest(std::span<const std::size_t> slots, const SightRows& seen);
  /// Sets the last action of a slot. \pre it has begun
  void tell(std::size_t slot, std::int64_t choice) { previous_[slot] = 1 + choice; }
  /// The input for the last action: kNoAction or 1 + choice.
  std::int64_t previous(std::size_t slot) const { return previous_[slot]; }

 private:
  const CeNetwork& network_;
  at::Tensor sentences_, states_;  // (slots, sentence), (slots, hidden)
  std::vector<std::int64_t> previous_;
};

/// Rule that chooses the performed action.
struct Mixture {
  /// Probability of the teacher's action, independently at each step.
  double teacher_share = 1;
  /// Else the network's: drawn by its probabilities, or the likeliest.
  bool drawn = true;
  /// The network stops at the latest with this action, counted from 1; 0: no limit.
  std::size_t last_action = 0;
};

/// What all walkers have in common. All but `sight` may not be null, and all outlive the walker.
struct GathererParts {
  const CeNetwork* network = nullptr;
  const models::InstructionWords* words = nullptr;
  const models::NetworkConfig* config = nullptr;
  SightEncoder* sight = nullptr;  ///< null: it does not see
};

/// Computes and records rollouts. An oracle: its teacher follows the reference path.
class Gatherer : public agents::ContinuousAgent {
 public:
  /// \param episodes those that are walked through, which outlive *this
  Gatherer(const GathererParts& parts, const Mixture& mixture,
           const tasks::ContinuousEpisodes& episodes);

  std::string_view name() const override { return "gatherer"; }
  bool needs_goal() const override { return true; }
  void start(std::size_t slot, const agents::ContinuousObservation& seen,
             const enfilade::continuous::SimulatorConfig& config) override;
  void act(std::span<const agents::ContinuousObservation> batch,
           std::span<enfilade::continuous::Action> actions) override;

  /// One an episode, in their order.
  const std::vector<RecordedEpisode>& walks() const noexcept { return walks_; }

 private:
  GathererParts parts_;
  Mixture mixture_;
  const tasks::ContinuousEpisodes& episodes_;
  std::unique_ptr<agents::ContinuousAgent> teacher_;
  EpisodeStates states_;
  double eye_height_ = 0;
  std::vector<RecordedEpisode> walks_;
};

/// Which of `batch` have not ended.
std::vector<std::size_t> walking(std::span<const agents::ContinuousObservation> batch);

}  // namespace enfilade::neural::continuous
