/// \file  The trained sequence-to-sequence agent as an Agent.
#pragma once
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/neural/core/view_features.h"
#include "enfilade/neural/seq2seq/evaluation.h"
#include "enfilade/neural/seq2seq/model.h"
#include "enfilade/neural/trained_agent.h"

namespace enfilade::neural::seq2seq {

/// Chooses the most likely action at each step, at most TrainConfig::max_steps (20).
class Seq2SeqAgent : public TrainedAgent {
 public:
  /// From load_model(); usable after enter().
  explicit Seq2SeqAgent(Model model) : model_(std::move(model)) {}

  const models::ModelConfig& config() const noexcept override { return model_.config; }
  std::uint64_t iteration() const noexcept override { return model_.iteration; }
  void enter(const tasks::EpisodeSet& episodes, const features::FeatureSet* features) override;
  std::vector<tasks::Trajectory> walk(const SplitRollout& options,
                                      const Progress& progress) override;

  std::string_view name() const override { return "seq2seq"; }
  void start(std::span<const agents::Observation> batch) override;
  void act(std::span<const agents::Observation> batch,
           std::span<agents::Decision> decisions) override;

 private:
  const core::ViewFeatures* features() const { return split_->view_features(); }

  Model model_;
  std::optional<PreparedSplit> split_;
  std::vector<ScanIndex> scans_;  // by slot
  std::vector<float> seen_;
  std::vector<std::uint8_t> forward_open_;
  std::vector<std::int32_t> actions_;
};

}  // namespace enfilade::neural::seq2seq
