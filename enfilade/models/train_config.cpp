#include "enfilade/models/train_config.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>

#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"
#include "enfilade/models/train_options.h"

namespace enfilade::models {
namespace {

constexpr std::size_t kBegin = 1;  // <BOS>, beside the words
constexpr std::array<std::string_view, 4> kInputs{"none", "language", "vision", "language+vision"};

// EnvDrop's run script.
void set_panoramic(TrainConfig& config) {
  config.optimizer = Optimizer::kRmsProp;
  config.adam.beta2 = 0.99;
  config.adam.weight_decay = 0;
  config.iterations = 80'000;
  config.batch_size = 64;
  config.max_steps = 35;
  config.evaluate_every = 1000;
  config.checkpoint_every = 500;
}

// DUET's fine-tuning for R2R. Its option for the decay is not connected, so that it is PyTorch's.
void set_duet(TrainConfig& config) {
  config.optimizer = Optimizer::kAdamW;
  config.adam.learning_rate = 1e-5;
  config.adam.weight_decay = 0.01;
  config.iterations = 200'000;
  config.batch_size = 8;
  config.max_steps = 15;
  config.network.max_words = 200;
  config.evaluate_every = 1000;
  config.checkpoint_every = 500;
}

// DUET's pretraining for R2R. Masked views are its only loss of pictures.
void set_pretraining(TrainConfig& config) {
  config.adam.learning_rate = 5e-5;
  config.adam.beta2 = 0.98;
  config.warm_up = 10'000;
  config.schedule = Schedule::kLinear;
  config.clip = 5;
  config.iterations = 100'000;
  config.batch_size = 64;
  config.duet.feature_dropout = 0;
}

// EnvDrop's run script for the speaker.
void set_speaker(TrainConfig& config) {
  config.adam.weight_decay = 0;
  config.iterations = 80'000;
  config.batch_size = 64;
  config.feedback = Feedback::kTeacher;
  config.evaluate_every = 1000;
  config.checkpoint_every = 500;
}

// VLN-CE's DAgger. Its walks are validated with `enfilade evaluate`: they have to be drawn.
void set_seq2seq_ce(TrainConfig& config) {
  config.adam.learning_rate = 2.5e-4;
  config.adam.weight_decay = 0;
  config.batch_size = 5;
  config.max_steps = 500;
  config.network.max_words = 200;
  config.evaluate_every = 0;
  config.checkpoint_every = 500;
  config.iterations = updates_of(config.seq2seq_ce, config.batch_size);
}

// For two cores and model homes; docs/neural.md has the time.
void make_small_seq2seq_ce(TrainConfig& config) {
  Seq2SeqCeConfig& sizes = config.seq2seq_ce;
  sizes.hidden = 256;
  sizes.picture = 128;
  sizes.sets = 5;
  sizes.set_walks = 1000;
  sizes.epochs = 6;
  config.adam.learning_rate = 1e-3;
  config.batch_size = 24;
  config.max_steps = 150;  // the expert's longest walk in 96 homes takes 117
  config.network.max_words = 120;
  config.checkpoint_every = 100;
  config.iterations = updates_of(sizes, config.batch_size);
}

// Larger steps than published, as nothing is pretrained; first values, not tuned.
void make_small(TrainConfig& config) {
  config.adam.learning_rate = 1e-3;
  config.iterations = 3000;
  config.evaluate_every = 500;
  config.checkpoint_every = 100;
  config.network.hidden = 256;
  if (config.agent == AgentKind::kSeq2Seq) return;
  config.network.max_words = 80;
  config.optimizer = Optimizer::kAdamW;
  config.adam.beta2 = 0.999;
  config.adam.weight_decay = 0.01;
  config.schedule = Schedule::kLinear;
  config.warm_up = 100;
  config.max_steps = 12;
  if (config.agent == AgentKind::kPanoramic) {
    config.panoramic.hidden = 256;
    config.panoramic.word_embedding = 128;
    config.panoramic.angle = 4;
    config.panoramic.subout = Subout::kOwnMax;
    config.sampled_loss = SampledLoss::kLabels;
    config.teacher_weight = 0.5;
    return;
  }
  if (config.agent == AgentKind::kSpeaker) {  // as the listener's; not tried
    config.speaker.hidden = 256;
    config.speaker.word_embedding = 128;
    config.speaker.angle = 4;
    return;
  }
  config.duet = duet_preset("duet-s");
  config.adam.learning_rate = 5e-4;
  config.batch_size = 16;
  config.clip = 5;
  if (config.stage == Stage::kPretrain) {
    config.duet.feature_dropout = 0;
    config.adam.beta2 = 0.98;
    config.batch_size = 32;
  }
}

void validate_speaker(const TrainConfig& config) {
  validate(speaker_sizes(config));
  if (config.feedback != Feedback::kTeacher) {
    throw ArgumentError("feedback student: the speaker is trained with teacher alone");
  }
  if (config.text != TextKind::kWords) {
    throw ArgumentError(
        fmt::format("text {}: the speaker writes words alone", to_string(config.text)));
  }
  if (!config.network.inputs.language) {
    throw ArgumentError(fmt::format("inputs {}: the speaker learns from instructions",
                                    to_string(config.network.inputs)));
  }
}

}  // namespace

void refuse_name(std::string_view what, std::string_view name,
                 std::span<const std::string_view> allowed) {
  throw ArgumentError(
      fmt::format("{} {}: {} is allowed", what, quote(name), fmt::join(allowed, " or ")));
}

TrainConfig recipe(AgentKind agent, Recipe source, Stage stage) {
  TrainConfig config;
  config.agent = agent;
  config.stage = stage;
  if (agent == AgentKind::kPanoramic) set_panoramic(config);
  if (agent == AgentKind::kDuet) set_duet(config);
  if (agent == AgentKind::kDuet && stage == Stage::kPretrain) set_pretraining(config);
  if (agent == AgentKind::kSpeaker) set_speaker(config);
  if (agent == AgentKind::kSeq2SeqCe) {
    set_seq2seq_ce(config);
    if (source == Recipe::kSmall) make_small_seq2seq_ce(config);
  } else if (source == Recipe::kSmall) {
    make_small(config);
  }
  return config;
}

void fix_updates(TrainConfig& config, std::size_t episodes) {
  if (config.agent != AgentKind::kSeq2SeqCe) return;
  config.seq2seq_ce.set_walks = std::min(config.seq2seq_ce.set_walks, episodes);
  config.iterations = updates_of(config.seq2seq_ce, config.batch_size);
}

PanoramicConfig panoramic_sizes(const TrainConfig& config) {
  PanoramicConfig sizes = config.panoramic;
  sizes.vocabulary = config.network.vocabulary + (config.text == TextKind::kWords ? kBegin : 0);
  sizes.image = config.network.features;
  return sizes;
}

SpeakerConfig speaker_sizes(const TrainConfig& config) {
  SpeakerConfig sizes = config.speaker;
  sizes.vocabulary = config.network.vocabulary + kBegin;
  sizes.image = config.network.features;
  return sizes;
}

DuetConfig duet_sizes(const TrainConfig& config) {
  constexpr std::size_t kBeginAndMask = 2;
  DuetConfig sizes = config.duet;
  sizes.vocabulary = static_cast<std::int64_t>(
      config.network.vocabulary + (config.text == TextKind::kWords ? kBeginAndMask : 0));
  sizes.image = static_cast<std::int64_t>(config.network.features);
  sizes.max_words = static_cast<std::int64_t>(config.network.max_words);
  sizes.max_actions = static_cast<std::int64_t>(config.max_steps);
  sizes.stays_where_it_stops = config.final_stop == StopRule::kOwn;
  return sizes;
}

std::size_t paper_iterations(Feedback feedback) noexcept {
  return feedback == Feedback::kTeacher ? 5'000 : 20'000;
}

std::string_view to_string(const Inputs& inputs) noexcept {
  return kInputs[(inputs.language ? 1U : 0U) + (inputs.vision ? 2U : 0U)];
}

Inputs parse_inputs(std::string_view name) {
  for (std::size_t i = 0; i < kInputs.size(); ++i) {
    if (kInputs[i] == name) return {(i & 1U) != 0, (i & 2U) != 0};
  }
  throw ArgumentError(
      fmt::format("inputs {}: one of {} is allowed", quote(name), fmt::join(kInputs, ", ")));
}

Feedback parse_feedback(std::string_view name) {
  if (name == "student") return Feedback::kSample;
  if (name == "teacher") return Feedback::kTeacher;
  throw ArgumentError(fmt::format("feedback {}: student or teacher is allowed", quote(name)));
}

void validate(const TrainConfig& config) {
  NetworkConfig network = config.network;
  network.vocabulary = 4;  // it, and features, come from the data
  if (network.features == 0) network.features = 1;
  validate(network);
  TrainConfig completed = config;
  completed.network = network;
  if (config.agent == AgentKind::kPanoramic) validate(panoramic_sizes(completed));
  if (config.agent == AgentKind::kDuet) validate(duet_sizes(completed));
  if (config.agent == AgentKind::kSpeaker) validate_speaker(completed);
  if (config.agent == AgentKind::kSeq2SeqCe) validate(config.seq2seq_ce);
  if (config.agent == AgentKind::kSeq2Seq && config.optimizer != Optimizer::kAdam) {
    throw ArgumentError(
        fmt::format("optimizer {}: seq2seq has adam alone", to_string(config.optimizer)));
  }
  const bool words_alone =
      config.agent == AgentKind::kSeq2Seq || config.agent == AgentKind::kSeq2SeqCe;
  if (words_alone && config.text != TextKind::kWords) {
    throw ArgumentError(fmt::format("text {}: {} reads words alone", to_string(config.text),
                                    to_string(config.agent)));
  }
  if (config.agent != AgentKind::kDuet && config.stage != Stage::kFineTune) {
    throw ArgumentError(fmt::format("stage {}: the agent {} has no such stage, duet has",
                                    to_string(config.stage), to_string(config.agent)));
  }
  if (config.feedback == Feedback::kArgmax) {
    throw ArgumentError("feedback argmax: student or teacher is allowed in training");
  }
  check_ranges(config);
}

}  // namespace enfilade::models
