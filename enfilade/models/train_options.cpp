#include "enfilade/models/train_options.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <type_traits>

#include "enfilade/core/errors.h"

namespace enfilade::models {
namespace {

constexpr AgentKinds bit(AgentKind kind) { return AgentKinds{1} << static_cast<unsigned>(kind); }
constexpr AgentKinds kSeq2Seq = bit(AgentKind::kSeq2Seq), kPanoramic = bit(AgentKind::kPanoramic),
                     kDuet = bit(AgentKind::kDuet), kSpeaker = bit(AgentKind::kSpeaker),
                     kCe = bit(AgentKind::kSeq2SeqCe);
constexpr AgentKinds kAll = kSeq2Seq | kPanoramic | kDuet | kSpeaker | kCe;
constexpr AgentKinds kOfGraph = kAll & ~kCe, kNewer = kAll & ~kSeq2Seq,
                     kViewpoints = kPanoramic | kDuet;

template <class T>
std::vector<std::string> names() {
  if constexpr (std::is_same_v<T, Inputs>) {
    return {"language+vision", "language", "vision", "none"};
  } else if constexpr (std::is_same_v<T, Feedback>) {
    return {"student", "teacher"};
  } else {
    const auto all = names_of(T{});
    return {all.begin(), all.end()};
  }
}

template <class T>
std::string_view name(const void* value) {
  const T& typed = *static_cast<const T*>(value);
  if constexpr (std::is_same_v<T, Feedback>) {
    return typed == Feedback::kTeacher ? "teacher" : "student";
  } else {
    return to_string(typed);
  }
}

template <class T>
void parse(void* value, [[maybe_unused]] std::string_view what, std::string_view name) {
  T& typed = *static_cast<T*>(value);
  if constexpr (std::is_same_v<T, Inputs>) {
    typed = parse_inputs(name);
  } else if constexpr (std::is_same_v<T, Feedback>) {
    typed = parse_feedback(name);
  } else {
    typed = parse_name<T>(what, name);
  }
}

template <class T>
OptionField field_of(T& value) {
  if constexpr (std::is_constructible_v<OptionField, std::in_place_type_t<T*>, T*>) {
    return &value;
  } else {
    return NamedField{&value, name<T>, parse<T>, names<T>};
  }
}

// A member of the configuration, or of one of its members.
template <auto... kMembers>
OptionField at(TrainConfig& config) {
  return field_of((config.*....*kMembers));
}

using T = TrainConfig;
constexpr TrainOption::Flag flag(std::string_view name, std::string_view help,
                                 AgentKinds kinds = kAll, std::uint64_t least = 1) {
  return {name, help, kinds, least};
}
constexpr TrainOption::Rules at_least(std::size_t least) { return {.least = least}; }
constexpr TrainOption::Rules at_most(double most) { return {.most = most}; }
constexpr TrainOption::Rules kNewField{.needed = false};
constexpr TrainOption::Rules kLettersRules{.needed = false, .applies = [](const T& config) {
                                             return config.text == TextKind::kWordPieces;
                                           }};
constexpr TrainOption::Flag kNoFlag;
constexpr TrainOption::Flag kWordsFlag{"--word-embedding", "Numbers per word"};
constexpr TrainOption::Flag kHiddenFlag{"--hidden", "Hidden size of all LSTMs; r2r-ce: of the GRU"};
constexpr TrainOption::Flag kActionsFlag{"--action-embedding",
                                         "Numbers per action, or for the agent's own direction"};
constexpr TrainOption::Flag kAngleFlag{"--angle", "Numbers per direction: 4, repeated", kAll, 4};
constexpr TrainOption::Flag kDropoutFlag{"--dropout", "Dropout, below 1"};
constexpr TrainOption::Flag kFeatureDropoutFlag{"--feature-dropout",
                                                "Dropout of image features, below 1"};

constexpr std::array<TrainOption, 45> kNetworkOptions{{
    {"vocabulary", kAll, at<&T::network, &NetworkConfig::vocabulary>},
    {"max_words", kAll, at<&T::network, &NetworkConfig::max_words>,
     flag("--max-words", "Most words of an instruction; the rest is cut off")},
    {"features", kAll, at<&T::network, &NetworkConfig::features>},
    {"inputs", kAll, at<&T::network, &NetworkConfig::inputs>,
     flag("--inputs", "Inputs of the agent (default: language+vision)")},
    {"text", kPanoramic | kDuet | kSpeaker, at<&T::text>, kNoFlag, kNewField},
    {"letters", kPanoramic | kDuet | kSpeaker, at<&T::letters>, kNoFlag, kLettersRules},
    // seq2seq
    {"word_embedding", kSeq2Seq, at<&T::network, &NetworkConfig::word_embedding>, kWordsFlag},
    {"hidden", kSeq2Seq, at<&T::network, &NetworkConfig::hidden>, kHiddenFlag},
    {"action_embedding", kSeq2Seq, at<&T::network, &NetworkConfig::action_embedding>, kActionsFlag},
    {"dropout", kSeq2Seq, at<&T::network, &NetworkConfig::dropout>, kDropoutFlag},
    // panoramic
    {"word_embedding", kPanoramic, at<&T::panoramic, &PanoramicConfig::word_embedding>, kWordsFlag},
    {"action_embedding", kPanoramic, at<&T::panoramic, &PanoramicConfig::action_embedding>,
     kActionsFlag},
    {"hidden", kPanoramic, at<&T::panoramic, &PanoramicConfig::hidden>, kHiddenFlag},
    {"angle", kPanoramic, at<&T::panoramic, &PanoramicConfig::angle>, kAngleFlag},
    {"bidirectional", kPanoramic, at<&T::panoramic, &PanoramicConfig::bidirectional>},
    {"subout", kPanoramic, at<&T::panoramic, &PanoramicConfig::subout>,
     flag("--subout",
          "Decoder's start: last state (tanh), maxima with padding (max) or without (own-max)")},
    {"dropout", kPanoramic, at<&T::panoramic, &PanoramicConfig::dropout>, kDropoutFlag},
    {"feature_dropout", kPanoramic, at<&T::panoramic, &PanoramicConfig::feature_dropout>,
     kFeatureDropoutFlag},
    // duet
    {"hidden", kDuet, at<&T::duet, &DuetConfig::hidden>},
    {"heads", kDuet, at<&T::duet, &DuetConfig::heads>},
    {"feed_forward", kDuet, at<&T::duet, &DuetConfig::feed_forward>},
    {"panorama_feed_forward", kDuet, at<&T::duet, &DuetConfig::panorama_feed_forward>},
    {"text_layers", kDuet, at<&T::duet, &DuetConfig::text_layers>},
    {"panorama_layers", kDuet, at<&T::duet, &DuetConfig::panorama_layers>},
    {"cross_layers", kDuet, at<&T::duet, &DuetConfig::cross_layers>},
    {"positions", kDuet, at<&T::duet, &DuetConfig::positions>},
    {"token_types", kDuet, at<&T::duet, &DuetConfig::token_types>},
    {"steps", kDuet, at<&T::duet, &DuetConfig::steps>},
    {"object", kDuet, at<&T::duet, &DuetConfig::object>},
    {"fusion", kDuet, at<&T::duet, &DuetConfig::fusion>},
    {"map_distances", kDuet, at<&T::duet, &DuetConfig::map_distances>},
    {"dropout", kDuet, at<&T::duet, &DuetConfig::dropout>, kDropoutFlag},
    {"feature_dropout", kDuet, at<&T::duet, &DuetConfig::feature_dropout>, kFeatureDropoutFlag},
    // speaker
    {"word_embedding", kSpeaker, at<&T::speaker, &SpeakerConfig::word_embedding>, kWordsFlag},
    {"hidden", kSpeaker, at<&T::speaker, &SpeakerConfig::hidden>, kHiddenFlag},
    {"angle", kSpeaker, at<&T::speaker, &SpeakerConfig::angle>, kAngleFlag},
    {"bidirectional", kSpeaker, at<&T::speaker, &SpeakerConfig::bidirectional>},
    {"dropout", kSpeaker, at<&T::speaker, &SpeakerConfig::dropout>, kDropoutFlag},
    {"feature_dropout", kSpeaker, at<&T::speaker, &SpeakerConfig::feature_dropout>,
     kFeatureDropoutFlag},
    // seq2seq-ce
    {"word_embedding", kCe, at<&T::seq2seq_ce, &Seq2SeqCeConfig::word_embedding>, kWordsFlag},
    {"sentence", kCe, at<&T::seq2seq_ce, &Seq2SeqCeConfig::sentence>},
    {"picture", kCe, at<&T::seq2seq_ce, &Seq2SeqCeConfig::picture>},
    {"depth", kCe, at<&T::seq2seq_ce, &Seq2SeqCeConfig::depth>},
    {"action_embedding", kCe, at<&T::seq2seq_ce, &Seq2SeqCeConfig::action_embedding>, kActionsFlag},
    {"hidden", kCe, at<&T::seq2seq_ce, &Seq2SeqCeConfig::hidden>, kHiddenFlag},
}};

constexpr std::array<TrainOption, 34> kTrainingOptions{{
    {"feedback", kOfGraph, at<&T::feedback>,
     flag("--feedback",
          "Action taken in training: sampled (student) or the teacher's (default: student)",
          ~kSpeaker)},
    {"iterations", kAll, at<&T::iterations>,
     flag("--iterations", "Updates; seq2seq with --feedback teacher: 5000", kOfGraph), at_least(1)},
    {"batch_size", kAll, at<&T::batch_size>, flag("--batch", "Episodes per iteration"),
     at_least(1)},
    {"parts", kAll, at<&T::parts>,
     flag("--parts",
          "Parts of a batch, shared by processes; weights equal one process's (default: as the "
          "model in -o; else 8 with a launcher, 1 without)")},
    {"max_steps", kAll, at<&T::max_steps>,
     flag("--max-steps", "Most actions, or choices of a viewpoint, per episode", ~kSpeaker),
     at_least(1)},
    {"after_end", kSeq2Seq, at<&T::after_end>,
     flag("--after-end",
          "After a stop away from the goal: walks-on (as released) or stays (default: walks-on)")},
    {"forward", kSeq2Seq, at<&T::forward>,
     flag("--forward",
          "Neighbour that forward reaches in training: nearest (as released) or intended "
          "(teacher's) (default: nearest)")},
    {"optimizer", kNewer, at<&T::optimizer>,
     flag("--optimizer",
          "Optimizer (default: panoramic rmsprop, duet adamw, others adam, as published)")},
    {"clip", kNewer, at<&T::clip>, flag("--clip", "Largest norm of the gradients"), at_most(1e9)},
    {"warm_up", kNewer, at<&T::warm_up>,
     flag("--warm-up", "First updates, in which the learning rate rises", kAll, 0)},
    {"schedule", kNewer, at<&T::schedule>,
     flag("--schedule", "Learning rate: constant, or linear to 0 (default: constant)")},
    {"teacher_weight", kViewpoints, at<&T::teacher_weight>,
     flag("--teacher-weight",
          "Weight of the teacher-forced rollout's loss, beside the sampled one's"),
     at_most(1)},
    {"inflection", kCe, at<&T::seq2seq_ce, &Seq2SeqCeConfig::inflection>,
     flag("--inflection", "r2r-ce: loss weight where the teacher's action changes, beside 1")},
    {"sets", kCe, at<&T::seq2seq_ce, &Seq2SeqCeConfig::sets>,
     flag("--sets", "r2r-ce: sets of rollouts, gathered one after another (DAgger)")},
    {"set_walks", kCe, at<&T::seq2seq_ce, &Seq2SeqCeConfig::set_walks>,
     flag("--set-walks", "r2r-ce: rollouts per set; all episodes, if there are fewer")},
    {"epochs", kCe, at<&T::seq2seq_ce, &Seq2SeqCeConfig::epochs>,
     flag("--epochs", "r2r-ce: passes over all sets so far, after each set")},
    {"teacher_share", kCe, at<&T::seq2seq_ce, &Seq2SeqCeConfig::teacher_share>,
     flag("--teacher-share", "r2r-ce: teacher's share of actions in set 2; then its powers")},
    {"sampled_loss", kPanoramic, at<&T::sampled_loss>,
     flag("--sampled-loss",
          "Loss of own rollouts: teacher's choices (labels) or actor-critic, as EnvDrop "
          "(reinforce) (default: reinforce)")},
    {"map_teacher", kDuet, at<&T::map_teacher>,
     flag("--map-teacher",
          "Teacher's node: on the shortest path (spl) or the annotated one (ndtw) (default: spl)")},
    {"final_stop", kDuet, at<&T::final_stop>,
     flag("--final-stop",
          "End of an episode: most probable stop (best, as released) or own (default: best)"),
     kNewField},
    {"stage", kDuet, at<&T::stage>, kNoFlag, kNewField},
    {"initial_weights", kDuet, at<&T::initial_weights>},
    {"seed", kAll, at<&T::seed>,
     flag("--seed", "Seed of weights, order, dropout and sampled actions", kAll, 0)},
    {"splits", kAll, at<&T::splits>, kNoFlag, at_least(1)},
    {"buildings", kAll, at<&T::buildings>, kNoFlag, at_least(1)},
    {"least_count", kAll, at<&T::least_count>,
     flag("--least-count", "Least count of a word in the vocabulary")},
    {"learning_rate", kAll, at<&T::adam, &AdamConfig::learning_rate>,
     flag("--learning-rate", "Learning rate of the optimizer"), at_most(1)},
    {"beta1", kAll, at<&T::adam, &AdamConfig::beta1>, kNoFlag, at_most(1)},
    {"beta2", kAll, at<&T::adam, &AdamConfig::beta2>,
     flag("--beta2", "Decay of the mean of squared gradients"), at_most(1)},
    {"epsilon", kAll, at<&T::adam, &AdamConfig::epsilon>, kNoFlag, at_most(1)},
    {"weight_decay", kAll, at<&T::adam, &AdamConfig::weight_decay>,
     flag("--weight-decay", "Weight decay: L2 in adam, decoupled in adamw"), at_most(1)},
    {"validation", kAll, at<&T::validation>},
    {"evaluate_every", kAll, at<&T::evaluate_every>,
     flag("--evaluate-every", "Iterations between validations; 0: never", kAll, 0)},
    {"checkpoint_every", kAll, at<&T::checkpoint_every>,
     flag("--checkpoint-every", "Iterations between checkpoints"), at_least(1)},
}};

}  // namespace

std::span<const TrainOption> network_options() { return kNetworkOptions; }
std::span<const TrainOption> training_options() { return kTrainingOptions; }

std::string TrainOption::words() const {
  std::string words(json);
  std::ranges::replace(words, '_', ' ');
  return words;
}

void check_ranges(const TrainConfig& config) {
  TrainConfig copy = config;  // as fields are found in a variable one
  for (const TrainOption& row : kTrainingOptions) {
    const OptionField field = row.field(copy);
    if (const auto* const real = std::get_if<double*>(&field);
        real != nullptr && row.rules.most > 0) {
      check_range(row.json, **real, 0, row.rules.most);
    }
    if (row.rules.least == 0) continue;
    std::size_t value = row.rules.least;
    if (const auto* const whole = std::get_if<std::size_t*>(&field)) value = **whole;
    if (const auto* const some = std::get_if<std::optional<std::size_t>*>(&field)) {
      value = (*some)->value_or(value);
    }
    if (const auto* const list = std::get_if<std::vector<std::string>*>(&field)) {
      value = (*list)->size();
    }
    if (value < row.rules.least) {
      throw ArgumentError(
          fmt::format("{}: {}, at least {} is needed", row.json, value, row.rules.least));
    }
  }
}

}  // namespace enfilade::models
