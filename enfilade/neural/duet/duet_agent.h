/// \file  The trained DUET as an Agent.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "enfilade/models/instruction_words.h"
#include "enfilade/neural/detail/planned_agent.h"
#include "enfilade/neural/duet/duet_split.h"

namespace enfilade::neural::duet {

/// Goes to the likeliest node of its map at each choice, through viewpoints that it knows, and in
/// the end to the one where stopping was most probable.
class DuetAgent : public detail::PlannedAgent {
 public:
  DuetAgent(models::ModelConfig config, models::InstructionWords words, std::uint64_t iteration,
            DuetNetwork network);

  std::vector<tasks::Trajectory> walk(const SplitWalk& options, const Progress& progress) override;

 protected:
  void prepare(const tasks::EpisodeSet& episodes, const features::FeatureSet* features) override;
  std::vector<tasks::Trajectory> walk(std::span<const std::size_t> episodes) override;

 private:
  models::InstructionWords words_;
  DuetNetwork network_;
  std::unique_ptr<DuetSplit> split_;
};

}  // namespace enfilade::neural::duet
