/// \file  How an agent is trained.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/models/network_config.h"

namespace enfilade::models {

/// The kinds of agents that are trained.
enum class AgentKind : std::uint8_t {
  kSeq2Seq,    ///< Anderson et al. 2018: six actions, no memory but an LSTM's
  kPanoramic,  ///< EnvDrop's listener (Tan et al. 2019): an LSTM that chooses among neighbours
  kDuet,       ///< DUET (Chen et al. 2022): a Transformer with a map
  kSpeaker,    ///< EnvDrop's speaker (Tan et al. 2019): describes paths in words
  kSeq2SeqCe,  ///< Krantz et al. 2020: continuous, with VLN-CE's four actions
};
constexpr std::array<std::string_view, 5> names_of(AgentKind /*enum*/) {
  return {"seq2seq", "panoramic", "duet", "speaker", "seq2seq-ce"};
}

/// Purpose of a training of duet.
enum class Stage : std::uint8_t {
  kFineTune,  ///< it chooses actions, with a teacher
  kPretrain,  ///< it guesses: masked words and views, the next step, the object
};
constexpr std::array<std::string_view, 2> names_of(Stage /*enum*/) {
  return {"fine-tune", "pretrain"};
}

/// Behaviour of an agent that chose `end` away from its goal, while others of its batch continue.
enum class AfterEnd {
  kWalksOn,  ///< as in the released code: it is still labelled and moved and adds to the loss; only
             ///< its recorded path has ended
  kStays,    ///< it neither moves nor is labelled
};
constexpr std::array<std::string_view, 2> names_of(AfterEnd /*enum*/) {
  return {"walks-on", "stays"};
}

/// The viewpoint that `forward` leads to.
enum class ForwardTo {
  kNearest,   ///< navigable index 1, as in the released code, even where the teacher's label means
              ///< another neighbour (18.6 % of labels), so teacher-forcing leaves the path
  kIntended,  ///< where the label is `forward`, the neighbour that it means, so the teacher stays
              ///< on the shortest path; uses the goal, so never for results
};
constexpr std::array<std::string_view, 2> names_of(ForwardTo /*enum*/) {
  return {"nearest", "intended"};
}

/// How gradients become updates.
enum class Optimizer : std::uint8_t {
  kAdam,     ///< with L2 regularisation inside: seq2seq's
  kAdamW,    ///< Adam with decay of the weights beside it (Loshchilov, Hutter 2019), as PyTorch's
  kRmsProp,  ///< without momentum, not centred, as PyTorch's; no decay
};
constexpr std::array<std::string_view, 3> names_of(Optimizer /*enum*/) {
  return {"adam", "adamw", "rmsprop"};
}

/// Learning rate after the warm-up.
enum class Schedule : std::uint8_t {
  kConstant,
  kLinear,  ///< falls to 0 at TrainConfig::iterations, which then cannot be changed later
};
constexpr std::array<std::string_view, 2> names_of(Schedule /*enum*/) {
  return {"constant", "linear"};
}

/// Loss of a panoramic agent's own rollout.
enum class SampledLoss : std::uint8_t {
  kLabels,     ///< the teacher's choice at every viewpoint: student-forcing
  kReinforce,  ///< rewards: advantage actor-critic, as EnvDrop
};
constexpr std::array<std::string_view, 2> names_of(SampledLoss /*enum*/) {
  return {"labels", "reinforce"};
}

/// The node of its map that an agent's teacher names in the agent's own rollout.
enum class MapTeacher : std::uint8_t {
  kSpl,   ///< the one with the shortest path through it to the goal
  kNdtw,  ///< the one that keeps nearest to the annotated path
};
constexpr std::array<std::string_view, 2> names_of(MapTeacher /*enum*/) { return {"spl", "ndtw"}; }

/// Last viewpoint of an agent with a map that has stopped by itself. Weights do not depend on it.
enum class StopRule : std::uint8_t {
  kBest,  ///< it goes back to where stopping was most probable, as the released DUET
  kOwn,   ///< it stays; it goes back only after the limit of actions
};
constexpr std::array<std::string_view, 2> names_of(StopRule /*enum*/) { return {"best", "own"}; }

/// Settings of a training. The defaults are the paper's for seq2seq and student-forcing; recipe()
/// has those of the other agents.
struct TrainConfig {
  AgentKind agent = AgentKind::kSeq2Seq;
  /// The network of seq2seq. Its `max_words`, `inputs`, `vocabulary` and `features` apply to every
  /// agent; the last two follow from the data.
  NetworkConfig network;
  /// Tokens of the agent; network.vocabulary counts its words or pieces. Seq2seq has only words.
  TextKind text = TextKind::kWords;
  Letters letters = Letters::kFolded;  ///< for word pieces
  PanoramicConfig panoramic;           ///< of that agent: all but `vocabulary` and `image`
  SpeakerConfig speaker;               ///< likewise
  DuetConfig duet;             ///< likewise; its max_words and max_actions do not count either
  Seq2SeqCeConfig seq2seq_ce;  ///< of seq2seq-ce
  /// Rates and decay of any optimizer. RMSprop's share of the old mean is beta2.
  AdamConfig adam;
  Optimizer optimizer = Optimizer::kAdam;  ///< seq2seq has Adam alone
  double clip = 40;         ///< largest norm of the gradients; not for seq2seq, which has no limit
  std::size_t warm_up = 0;  ///< first updates, in which the rate rises; not for seq2seq
  Schedule schedule = Schedule::kConstant;  ///< not for seq2seq
  /// kTeacher: teacher-forced rollouts only. kSample: its own rollouts, and teacher-forced ones by
  /// `teacher_weight`. Not kArgmax.
  Feedback feedback = Feedback::kSample;
  /// Weight of the loss of a teacher-forced rollout beside its own; 0: none. Not for seq2seq.
  double teacher_weight = 0.2;
  SampledLoss sampled_loss = SampledLoss::kReinforce;  ///< for panoramic
  MapTeacher map_teacher = MapTeacher::kSpl;           ///< duet only
  StopRule final_stop = StopRule::kBest;               ///< duet only
  Stage stage = Stage::kFineTune;                      ///< duet only
  /// duet only: the hash of another model's weights (in its file) that training began with. No
  /// value: random ones.
  std::optional<std::string> initial_weights = {};
  std::size_t iterations = 20'000;  ///< for seq2seq-ce they follow: see fix_updates()
  std::size_t batch_size = 100;
  /// Parts that a batch is computed in, one after the other or by several processes. Their
  /// gradients are added in an order that does not depend on the number of processes. No value: all
  /// at once. 0: one part per process, added as they come, so that results depend on the number of
  /// processes.
  std::optional<std::size_t> parts = {};
  /// Actions per episode; for agents that choose among viewpoints, choices.
  std::size_t max_steps = 20;
  AfterEnd after_end = AfterEnd::kWalksOn;  ///< seq2seq only
  ForwardTo forward = ForwardTo::kNearest;  ///< seq2seq only
  std::uint64_t seed = 1;  ///< of weights, order of episodes, dropout and sampled actions
  std::vector<std::string> splits{"train"};  ///< trained on; the vocabulary is made of them too
  /// Number of buildings whose paths are trained on, the first ones in the files: for curves of
  /// success by the number of buildings. No value: all.
  std::optional<std::size_t> buildings = {};
  std::size_t least_count = 5;  ///< occurrences of a word in the vocabulary
  /// Splits of which validation loss and greedy scores are computed every `evaluate_every`
  /// iterations (0: never) and after the last. Does not affect the weights.
  std::vector<std::string> validation{"val_seen", "val_unseen"};
  std::size_t evaluate_every = 100;
  std::size_t checkpoint_every = 100;  ///< iterations; also after the last
};

/// Source of a training's settings.
enum class Recipe : std::uint8_t {
  kPublished,  ///< EnvDrop's run script, DUET's of R2R, the paper's of seq2seq: the defaults
  kSmall,      ///< ours: small networks from nothing, in synthetic homes, on two cores
};
constexpr std::array<std::string_view, 2> names_of(Recipe /*enum*/) {
  return {"published", "small"};
}

/// The settings of one agent by one recipe. \param stage of duet
TrainConfig recipe(AgentKind agent, Recipe source = Recipe::kPublished,
                   Stage stage = Stage::kFineTune);

/// seq2seq-ce: its sets have no more rollouts than there are episodes, and `iterations` are the
/// updates_of() those sets. Other agents do not change.
/// \param episodes trained on
void fix_updates(TrainConfig& config, std::size_t episodes);

/// The sizes of the networks, with what follows from the data. `<BOS>` and `<MASK>` have rows
/// beside those of words; pieces have all of theirs. \pre the agent is of that kind
PanoramicConfig panoramic_sizes(const TrainConfig& config);
DuetConfig duet_sizes(const TrainConfig& config);        ///< likewise
SpeakerConfig speaker_sizes(const TrainConfig& config);  ///< likewise

/// The paper's number of iterations: 5,000 for kTeacher, 20,000 for kSample.
std::size_t paper_iterations(Feedback feedback) noexcept;

/// The name in "--inputs": "language+vision", "language", "vision", "none".
std::string_view to_string(const Inputs& inputs) noexcept;
/// \throws ArgumentError naming the four names
Inputs parse_inputs(std::string_view name);
/// "student" or "teacher". \throws ArgumentError
Feedback parse_feedback(std::string_view name);

/// Checks everything but network.vocabulary and network.features.
/// \throws ArgumentError naming the field, its value and the allowed range
void validate(const TrainConfig& config);

/// Reasons why the weights of one network cannot be those of another: agents, texts and sizes that
/// differ ("hidden: 512, not 256"). Settings used only in training, and max_words, may differ.
std::vector<std::string> size_differences(const TrainConfig& there, const TrainConfig& here);

/// The differences of two configs that affect the weights ("hidden: 512, not 256"). Left out are
/// iterations, validation splits and how often to evaluate and to write checkpoints.
std::vector<std::string> differences(const TrainConfig& there, const TrainConfig& here);

}  // namespace enfilade::models
