#include "enfilade/neural/trained_agent.h"

#include <fmt/format.h>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/neural/core/torch_device.h"
#include "enfilade/neural/core/viewpoint_agent.h"
#include "enfilade/neural/duet/duet_split.h"
#include "enfilade/neural/panoramic/panoramic_split.h"
#include "enfilade/neural/seq2seq/model.h"
#include "enfilade/neural/seq2seq/seq2seq_agent.h"

namespace enfilade::neural {

namespace fs = std::filesystem;

std::unique_ptr<TrainedAgent> load_trained_agent(const fs::path& folder,
                                                 const std::string& device_name) {
  const models::ModelFiles files = models::require_model(folder);
  const models::ModelConfig config = models::load_model_config(files.config());
  const models::AgentKind kind = config.training.agent;
  if (kind == models::AgentKind::kSeq2Seq) {
    return std::make_unique<seq2seq::Seq2SeqAgent>(seq2seq::load_model(folder, device_name));
  }
  if (kind == models::AgentKind::kSpeaker) {
    throw ArgumentError(fmt::format("{}: a speaker, which describes paths and does not walk them",
                                    folder.string()));
  }
  if (kind == models::AgentKind::kSeq2SeqCe) {
    throw ArgumentError(fmt::format("{}: a continuous agent, not one of the graph: --task r2r-ce",
                                    folder.string()));
  }
  const c10::Device device = core::open_agents_device(device_name);
  models::InstructionWords words = models::load_instruction_words(files, config.training);
  const models::StateFile state = models::open_state(files.weights());
  // EnvDrop's trajectories have an entry a turn, and it turns to the right only. DUET's have none.
  if (kind == models::AgentKind::kDuet) {
    return std::make_unique<core::ViewpointAgent<duet::DuetNetwork, duet::DuetSplit>>(
        config, std::move(words), state.iteration,
        duet::DuetNetwork(duet_sizes(config.training), state.file, device),
        agents::Turning::kShorter);
  }
  using panoramic::PanoramicNetwork;
  return std::make_unique<core::ViewpointAgent<PanoramicNetwork, panoramic::PanoramicSplit>>(
      config, std::move(words), state.iteration,
      PanoramicNetwork(panoramic_sizes(config.training), state.file, device),
      agents::Turning::kRight);
}

}  // namespace enfilade::neural
