#include "enfilade/models/train_config.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "enfilade/core/errors.h"
#include "enfilade/models/detail/config_json.h"
#include "enfilade/models/detail/named_values.h"

namespace enfilade::models {
namespace {

using detail::NamedValues;
using Json = nlohmann::ordered_json;

constexpr std::array<std::string_view, 4> kInputs{"none", "language", "vision", "language+vision"};

// What weights do not depend on.
bool is_free(std::string_view field, Schedule schedule) {
  const bool length = field == "iterations" || field == "sets";
  return (length && schedule == Schedule::kConstant) || field == "validation" ||
         field == "evaluate_every" || field == "checkpoint_every" || field == "final_stop";
}

constexpr NamedValues<AgentKind, 5> kAgents{
    "agent", {"seq2seq", "panoramic", "duet", "speaker", "seq2seq-ce"}};
constexpr NamedValues<Optimizer, 3> kOptimizers{"optimizer", {"adam", "adamw", "rmsprop"}};
constexpr NamedValues<TextKind, 3> kTexts{"text", {"words", "word-pieces", "sentence-pieces"}};
constexpr NamedValues<Letters, 2> kLetters{"letters", {"cased", "uncased"}};
constexpr NamedValues<Schedule, 2> kSchedules{"schedule", {"constant", "linear"}};
constexpr NamedValues<SampledLoss, 2> kSampledLosses{"sampled loss", {"labels", "reinforce"}};
constexpr NamedValues<Stage, 2> kStages{"stage", {"fine-tune", "pretrain"}};
constexpr NamedValues<MapTeacher, 2> kMapTeachers{"map teacher", {"spl", "ndtw"}};
constexpr NamedValues<FinalStop, 2> kFinalStops{"final stop", {"best", "own"}};
constexpr NamedValues<Recipe, 2> kRecipes{"recipe", {"published", "small"}};
constexpr NamedValues<AfterEnd, 2> kAfterEnds{"after end", {"walks-on", "stays"}};
constexpr NamedValues<ForwardTo, 2> kForwards{"forward", {"nearest", "intended"}};

constexpr double kMostNorm = 1e9;

void check_positive(const char* name, std::size_t value) {
  if (value > 0) return;
  throw ArgumentError(fmt::format("{}: 0, at least 1 is needed", name));
}

void check_adam(const AdamConfig& adam) {
  check_range("learning_rate", adam.learning_rate, 0, 1);
  check_range("beta1", adam.beta1, 0, 1);
  check_range("beta2", adam.beta2, 0, 1);
  check_range("epsilon", adam.epsilon, 0, 1);
  check_range("weight_decay", adam.weight_decay, 0, 1);
}

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

std::string_view to_string(AgentKind value) noexcept { return kAgents.name(value); }
AgentKind parse_agent_kind(std::string_view name) { return kAgents.parse(name); }
std::string_view to_string(Optimizer value) noexcept { return kOptimizers.name(value); }
Optimizer parse_optimizer(std::string_view name) { return kOptimizers.parse(name); }
std::string_view to_string(TextKind value) noexcept { return kTexts.name(value); }
TextKind parse_text_kind(std::string_view name) { return kTexts.parse(name); }
std::string_view to_string(Letters value) noexcept { return kLetters.name(value); }
Letters parse_letters(std::string_view name) { return kLetters.parse(name); }
std::string_view to_string(Schedule value) noexcept { return kSchedules.name(value); }
Schedule parse_schedule(std::string_view name) { return kSchedules.parse(name); }
std::string_view to_string(SampledLoss value) noexcept { return kSampledLosses.name(value); }
SampledLoss parse_sampled_loss(std::string_view name) { return kSampledLosses.parse(name); }
std::string_view to_string(Stage value) noexcept { return kStages.name(value); }
Stage parse_stage(std::string_view name) { return kStages.parse(name); }
std::string_view to_string(MapTeacher value) noexcept { return kMapTeachers.name(value); }
MapTeacher parse_map_teacher(std::string_view name) { return kMapTeachers.parse(name); }
std::string_view to_string(FinalStop value) noexcept { return kFinalStops.name(value); }
FinalStop parse_final_stop(std::string_view name) { return kFinalStops.parse(name); }
std::string_view to_string(Recipe value) noexcept { return kRecipes.name(value); }
Recipe parse_recipe(std::string_view name) { return kRecipes.parse(name); }
std::string_view to_string(AfterEnd value) noexcept { return kAfterEnds.name(value); }
AfterEnd parse_after_end(std::string_view name) { return kAfterEnds.parse(name); }
std::string_view to_string(ForwardTo value) noexcept { return kForwards.name(value); }
ForwardTo parse_forward_to(std::string_view name) { return kForwards.parse(name); }

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
  constexpr std::size_t kBegin = 1;  // <BOS>
  PanoramicConfig sizes = config.panoramic;
  sizes.vocabulary = config.network.vocabulary + (config.text == TextKind::kWords ? kBegin : 0);
  sizes.image = config.network.features;
  return sizes;
}

SpeakerConfig speaker_sizes(const TrainConfig& config) {
  constexpr std::size_t kBegin = 1;  // <BOS>
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
  sizes.stays_where_it_stops = config.final_stop == FinalStop::kOwn;
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
      fmt::format("inputs {:?}: one of {} is allowed", name, fmt::join(kInputs, ", ")));
}

Feedback parse_feedback(std::string_view name) {
  if (name == "student") return Feedback::kSample;
  if (name == "teacher") return Feedback::kTeacher;
  throw ArgumentError(fmt::format("feedback {:?}: student or teacher is allowed", name));
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
  check_range("clip", config.clip, 0, kMostNorm);
  check_range("teacher_weight", config.teacher_weight, 0, 1);
  check_adam(config.adam);
  if (config.feedback == Feedback::kArgmax) {
    throw ArgumentError("feedback argmax: student or teacher is allowed in training");
  }
  check_positive("batch_size", config.batch_size);
  check_positive("max_steps", config.max_steps);
  check_positive("iterations", config.iterations);
  check_positive("checkpoint_every", config.checkpoint_every);
  check_positive("splits", config.splits.size());
  if (config.buildings) check_positive("buildings", *config.buildings);
}

namespace {

// Differences of two objects, except the names that are left out.
template <class LeftOut>
void compare(const Json& a, const Json& b, const LeftOut& left_out,
             std::vector<std::string>& found) {
  const auto text = [](const Json& config, const std::string& name) {
    return config.contains(name) ? config.at(name).dump() : std::string("none");
  };
  Json names = a;
  names.update(b);  // either may lack what it has no value for
  for (const auto& [name, value] : names.items()) {
    const std::string was = text(a, name), is = text(b, name);
    if (left_out(name) || was == is) continue;
    found.push_back(fmt::format("{}: {}, not {}", name, was, is));
  }
}

std::vector<std::string> other_agent(const TrainConfig& there, const TrainConfig& here) {
  if (there.agent == here.agent) return {};
  return {fmt::format("agent: {}, not {}", to_string(there.agent), to_string(here.agent))};
}

}  // namespace

std::vector<std::string> size_differences(const TrainConfig& there, const TrainConfig& here) {
  std::vector<std::string> found = other_agent(there, here);
  if (!found.empty()) return found;
  const auto left_out = [](std::string_view name) {
    return name == "max_words" || name == "inputs" || name == "dropout" ||
           name == "feature_dropout";
  };
  compare(detail::network_to_json(there), detail::network_to_json(here), left_out, found);
  return found;
}

std::vector<std::string> differences(const TrainConfig& there, const TrainConfig& here) {
  std::vector<std::string> found = other_agent(there, here);
  if (!found.empty()) return found;
  const auto free = [&](std::string_view name) { return is_free(name, here.schedule); };
  compare(detail::network_to_json(there), detail::network_to_json(here), free, found);
  compare(detail::to_json(there), detail::to_json(here), free, found);
  return found;
}

}  // namespace enfilade::models
