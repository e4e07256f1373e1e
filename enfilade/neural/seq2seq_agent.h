/// \file  The trained sequence-to-sequence agent as an Agent.
#pragma once
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "enfilade/agents/agent.h"
#include "enfilade/neural/model.h"
#include "enfilade/neural/view_features.h"

namespace enfilade::neural {

/// Chooses the most likely action at each step, at most TrainConfig::max_steps (20), in the
/// simulator's room_to_room() configuration. walk_greedily() makes the same trajectories faster.
class Seq2SeqAgent : public agents::Agent {
 public:
  /// \param features of the episodes' scans; none if the model does not see
  /// \throws ArgumentError if the model sees and there are none, or their size is not the network's
  Seq2SeqAgent(Model model, std::optional<ViewFeatures> features);

  std::string_view name() const override { return "seq2seq"; }
  void start(std::span<const agents::Observation> batch) override;
  void act(std::span<const agents::Observation> batch,
           std::span<agents::Decision> decisions) override;

 private:
  Model model_;
  std::optional<ViewFeatures> features_;
  std::vector<ScanIndex> scans_;  // by slot
  std::vector<float> seen_;
  std::vector<std::uint8_t> forward_open_;
  std::vector<std::int32_t> actions_;
};

}  // namespace enfilade::neural
