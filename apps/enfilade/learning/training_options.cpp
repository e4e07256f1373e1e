#include "apps/enfilade/learning/training_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "apps/common/program.h"

namespace enfilade::apps {
namespace {

using models::AgentKind;
using models::TrainConfig;

constexpr std::array<AgentKind, 5> kKinds{AgentKind::kSeq2Seq, AgentKind::kPanoramic,
                                          AgentKind::kDuet, AgentKind::kSpeaker,
                                          AgentKind::kSeq2SeqCe};
// All that have no DAgger.
const std::vector<AgentKind> kOfGraph{AgentKind::kSeq2Seq, AgentKind::kPanoramic, AgentKind::kDuet,
                                      AgentKind::kSpeaker};

// Of what an agent is taught while it walks.
constexpr std::array<std::string_view, 3> kOfWalks{"--feedback", "--map-teacher",
                                                   "--teacher-weight"};

// "(default: 100; panoramic 64, duet 8)"
template <class Field>
std::string defaults(const std::vector<AgentKind>& kinds, const Field& field) {
  std::vector<std::string> texts;
  std::string first;
  for (const AgentKind kind : kinds.empty() ? std::vector(kKinds.begin(), kKinds.end()) : kinds) {
    TrainConfig config = models::recipe(kind);
    const std::string text = fmt::format("{}", field(config));
    if (first.empty()) first = text;
    if (text != first) texts.push_back(fmt::format("{} {}", to_string(kind), text));
  }
  return fmt::format(" (default: {}{}{})", first, texts.empty() ? "" : "; ",
                     fmt::join(texts, ", "));
}

}  // namespace

template <class T>
CLI::Option* TrainingOptions::change(CLI::App& verb, const std::string& name,
                                     const std::string& help, const Kinds& kinds,
                                     const std::function<void(TrainConfig&, const T&)>& apply) {
  const auto value = std::make_shared<T>();
  CLI::Option* const option = verb.add_option(name, *value, help);
  changes_.push_back(
      {option, kinds, [value, apply](TrainConfig& config) { apply(config, *value); }});
  return option;
}

void TrainingOptions::whole(CLI::App& verb, const std::string& name, const std::string& help,
                            const Kinds& kinds,
                            const std::function<std::size_t&(TrainConfig&)>& field,
                            std::uint64_t least) {
  change<std::size_t>(verb, name, help + defaults(kinds, field), kinds,
                      [field](TrainConfig& config, std::size_t value) { field(config) = value; })
      ->check(whole_number(least));
}

void TrainingOptions::real(CLI::App& verb, const std::string& name, const std::string& help,
                           const Kinds& kinds, const std::function<double&(TrainConfig&)>& field) {
  change<double>(verb, name, help + defaults(kinds, field), kinds,
                 [field](TrainConfig& config, double value) { field(config) = value; })
      ->check(finite_number());
}

void TrainingOptions::name(CLI::App& verb, const std::string& name, const std::string& help,
                           const Kinds& kinds, const std::vector<std::string>& allowed,
                           const std::function<void(TrainConfig&, const std::string&)>& apply) {
  change<std::string>(verb, name, help, kinds, apply)->check(CLI::IsMember(allowed));
}

void TrainingOptions::add_to(CLI::App& verb, const std::string& recipe) {
  agent_ = "seq2seq";
  recipe_ = recipe;
  stage_ = "fine-tune";
  task_ = "r2r";
  add_setting(verb, "--agent", agent_, "",
              "Agent: seq2seq (2018), panoramic (EnvDrop, 2019), duet (2022), or EnvDrop's speaker",
              CLI::IsMember({"seq2seq", "panoramic", "duet", "speaker"}));
  add_setting(verb, "--task", task_, "",
              "r2r (graph), or r2r-ce (continuous: seq2seq, after `enfilade continuous`)",
              CLI::IsMember({"r2r", "r2r-ce"}));
  add_setting(verb, "--recipe", recipe_, "",
              "Base of the options below: published, or small (homes, two cores)",
              CLI::IsMember({"published", "small"}));
  add_setting(verb, "--stage", stage_, "",
              "duet: fine-tune (episodes) or pretrain (masked words and views, next step)",
              CLI::IsMember({"fine-tune", "pretrain"}));
  name(verb, "--feedback",
       "Action taken in training: sampled (student) or the teacher's "
       "(default: student)",
       {AgentKind::kSeq2Seq, AgentKind::kPanoramic, AgentKind::kDuet}, {"student", "teacher"},
       [this](TrainConfig& config, const std::string& value) {
         config.feedback = models::parse_feedback(value);
         if (config.agent == AgentKind::kSeq2Seq && recipe_ == "published") {
           config.iterations = models::paper_iterations(config.feedback);
         }
       });
  name(verb, "--inputs", "Inputs of the agent (default: language+vision)", {},
       {"language+vision", "language", "vision", "none"},
       [](TrainConfig& config, const std::string& value) {
         config.network.inputs = models::parse_inputs(value);
       });
  name(verb, "--after-end",
       "After a stop away from the goal: walks-on (as released) or stays (default: walks-on)",
       {AgentKind::kSeq2Seq}, {"walks-on", "stays"},
       [](TrainConfig& config, const std::string& value) {
         config.after_end = models::parse_after_end(value);
       });
  name(verb, "--forward",
       "Neighbour that forward reaches in training: nearest (as released) or intended "
       "(teacher's) (default: nearest)",
       {AgentKind::kSeq2Seq}, {"nearest", "intended"},
       [](TrainConfig& config, const std::string& value) {
         config.forward = models::parse_forward_to(value);
       });
  name(verb, "--sampled-loss",
       "Loss of own rollouts: teacher's choices (labels) or actor-critic, as EnvDrop (reinforce) "
       "(default: reinforce)",
       {AgentKind::kPanoramic}, {"labels", "reinforce"},
       [](TrainConfig& config, const std::string& value) {
         config.sampled_loss = models::parse_sampled_loss(value);
       });
  name(verb, "--map-teacher",
       "Teacher's node: on the shortest path (spl) or the annotated one (ndtw) (default: spl)",
       {AgentKind::kDuet}, {"spl", "ndtw"}, [](TrainConfig& config, const std::string& value) {
         config.map_teacher = models::parse_map_teacher(value);
       });
  name(verb, "--final-stop",
       "End of an episode: most probable stop (best, as released) or own (default: best)",
       {AgentKind::kDuet}, {"best", "own"}, [](TrainConfig& config, const std::string& value) {
         config.final_stop = models::parse_final_stop(value);
       });
  add_updates(verb);
  add_sizes(verb);
  add_seq2seq_ce(verb);
}

void TrainingOptions::add_updates(CLI::App& verb) {
  const Kinds viewpoints{AgentKind::kPanoramic, AgentKind::kDuet};
  const Kinds newer{AgentKind::kPanoramic, AgentKind::kDuet, AgentKind::kSpeaker,
                    AgentKind::kSeq2SeqCe};
  whole(verb, "--iterations", "Updates; seq2seq with --feedback teacher: 5000", kOfGraph,
        [](TrainConfig& config) -> std::size_t& { return config.iterations; });
  whole(verb, "--batch", "Episodes per iteration", {},
        [](TrainConfig& config) -> std::size_t& { return config.batch_size; });
  change<std::uint64_t>(
      verb, "--parts",
      "Parts of a batch, shared by processes; weights equal one process's (default: as the model "
      "in -o; else 8 with a launcher, 1 without)",
      {}, [](TrainConfig& config, std::uint64_t parts) { config.parts = parts; })
      ->check(whole_number(1));
  whole(verb, "--max-steps", "Most actions, or choices of a viewpoint, per episode",
        {AgentKind::kSeq2Seq, AgentKind::kPanoramic, AgentKind::kDuet, AgentKind::kSeq2SeqCe},
        [](TrainConfig& config) -> std::size_t& { return config.max_steps; });
  whole(
      verb, "--evaluate-every", "Iterations between validations; 0: never", {},
      [](TrainConfig& config) -> std::size_t& { return config.evaluate_every; }, 0);
  whole(verb, "--checkpoint-every", "Iterations between checkpoints", {},
        [](TrainConfig& config) -> std::size_t& { return config.checkpoint_every; });
  change<std::uint64_t>(verb, "--seed",
                        "Seed of weights, order, dropout and sampled actions "
                        "(default: 1)",
                        {}, [](TrainConfig& config, std::uint64_t seed) { config.seed = seed; })
      ->check(whole_number(0));
  real(verb, "--teacher-weight",
       "Weight of the teacher-forced rollout's loss, beside the "
       "sampled one's",
       viewpoints, [](TrainConfig& config) -> double& { return config.teacher_weight; });
  real(verb, "--learning-rate", "Learning rate of the optimizer", {},
       [](TrainConfig& config) -> double& { return config.adam.learning_rate; });
  real(verb, "--weight-decay", "Weight decay: L2 in adam, decoupled in adamw", {},
       [](TrainConfig& config) -> double& { return config.adam.weight_decay; });
  name(verb, "--optimizer",
       "Optimizer (default: panoramic rmsprop, duet adamw, others adam, as "
       "published)",
       newer, {"adam", "adamw", "rmsprop"}, [](TrainConfig& config, const std::string& value) {
         config.optimizer = models::parse_optimizer(value);
       });
  real(verb, "--beta2", "Decay of the mean of squared gradients", {},
       [](TrainConfig& config) -> double& { return config.adam.beta2; });
  real(verb, "--clip", "Largest norm of the gradients", newer,
       [](TrainConfig& config) -> double& { return config.clip; });
  whole(
      verb, "--warm-up", "First updates, in which the learning rate rises", newer,
      [](TrainConfig& config) -> std::size_t& { return config.warm_up; }, 0);
  name(verb, "--schedule", "Learning rate: constant, or linear to 0 (default: constant)", newer,
       {"constant", "linear"}, [](TrainConfig& config, const std::string& value) {
         config.schedule = models::parse_schedule(value);
       });
}

void TrainingOptions::add_sizes(CLI::App& verb) {
  const Kinds lstms{AgentKind::kSeq2Seq, AgentKind::kPanoramic, AgentKind::kSpeaker,
                    AgentKind::kSeq2SeqCe};
  const Kinds panoramic{AgentKind::kPanoramic};
  const Kinds newer{AgentKind::kPanoramic, AgentKind::kDuet, AgentKind::kSpeaker};
  name(verb, "--size", "Sizes of DUET: as published (duet) or small (duet-s) (default: duet)",
       {AgentKind::kDuet}, {"duet-s", "duet"}, [](TrainConfig& config, const std::string& value) {
         const double dropped = config.duet.feature_dropout;  // the stage's
         config.duet = models::duet_preset(value);
         config.duet.feature_dropout = dropped;
       });
  whole(verb, "--hidden", "Hidden size of all LSTMs; r2r-ce: of the GRU", lstms,
        [](TrainConfig& config) -> std::size_t& {
          if (config.agent == AgentKind::kSeq2SeqCe) return config.seq2seq_ce.hidden;
          if (config.agent == AgentKind::kSpeaker) return config.speaker.hidden;
          return config.agent == AgentKind::kPanoramic ? config.panoramic.hidden
                                                       : config.network.hidden;
        });
  whole(verb, "--word-embedding", "Numbers per word", lstms,
        [](TrainConfig& config) -> std::size_t& {
          if (config.agent == AgentKind::kSeq2SeqCe) return config.seq2seq_ce.word_embedding;
          if (config.agent == AgentKind::kSpeaker) return config.speaker.word_embedding;
          return config.agent == AgentKind::kPanoramic ? config.panoramic.word_embedding
                                                       : config.network.word_embedding;
        });
  whole(verb, "--action-embedding", "Numbers per action, or for the agent's own direction",
        {AgentKind::kSeq2Seq, AgentKind::kPanoramic, AgentKind::kSeq2SeqCe},
        [](TrainConfig& config) -> std::size_t& {
          if (config.agent == AgentKind::kSeq2SeqCe) return config.seq2seq_ce.action_embedding;
          return config.agent == AgentKind::kPanoramic ? config.panoramic.action_embedding
                                                       : config.network.action_embedding;
        });
  whole(
      verb, "--angle", "Numbers per direction: 4, repeated",
      {AgentKind::kPanoramic, AgentKind::kSpeaker},
      [](TrainConfig& config) -> std::size_t& {
        return config.agent == AgentKind::kSpeaker ? config.speaker.angle : config.panoramic.angle;
      },
      4);
  name(verb, "--subout",
       "Decoder's start: last state (tanh), maxima with padding (max) or without (own-max)",
       panoramic, {"tanh", "max", "own-max"}, [](TrainConfig& config, const std::string& value) {
         config.panoramic.subout = models::parse_subout(value);
       });
  whole(verb, "--max-words", "Most words of an instruction; the rest is cut off", {},
        [](TrainConfig& config) -> std::size_t& { return config.network.max_words; });
  whole(verb, "--least-count", "Least count of a word in the vocabulary", {},
        [](TrainConfig& config) -> std::size_t& { return config.least_count; });
  real(verb, "--dropout", "Dropout, below 1", kOfGraph, [](TrainConfig& config) -> double& {
    switch (config.agent) {
      case AgentKind::kPanoramic:
        return config.panoramic.dropout;
      case AgentKind::kDuet:
        return config.duet.dropout;
      case AgentKind::kSpeaker:
        return config.speaker.dropout;
      default:
        return config.network.dropout;
    }
  });
  real(verb, "--feature-dropout", "Dropout of image features, below 1",
       {AgentKind::kPanoramic, AgentKind::kDuet, AgentKind::kSpeaker},
       [](TrainConfig& config) -> double& {
         if (config.agent == AgentKind::kSpeaker) return config.speaker.feature_dropout;
         return config.agent == AgentKind::kDuet ? config.duet.feature_dropout
                                                 : config.panoramic.feature_dropout;
       });
}

void TrainingOptions::add_seq2seq_ce(CLI::App& verb) {
  const Kinds free{AgentKind::kSeq2SeqCe};
  whole(verb, "--sets", "r2r-ce: sets of rollouts, gathered one after another (DAgger)", free,
        [](TrainConfig& config) -> std::size_t& { return config.seq2seq_ce.sets; });
  whole(verb, "--set-walks", "r2r-ce: rollouts per set; all episodes, if there are fewer", free,
        [](TrainConfig& config) -> std::size_t& { return config.seq2seq_ce.set_walks; });
  whole(verb, "--epochs", "r2r-ce: passes over all sets so far, after each set", free,
        [](TrainConfig& config) -> std::size_t& { return config.seq2seq_ce.epochs; });
  real(verb, "--teacher-share", "r2r-ce: teacher's share of actions in set 2; then its powers",
       free, [](TrainConfig& config) -> double& { return config.seq2seq_ce.teacher_share; });
  real(verb, "--inflection", "r2r-ce: loss weight where the teacher's action changes, beside 1",
       free, [](TrainConfig& config) -> double& { return config.seq2seq_ce.inflection; });
}

AgentKind TrainingOptions::kind() const {
  const AgentKind kind = models::parse_agent_kind(agent_);
  if (task_ != "r2r-ce") return kind;
  if (kind == AgentKind::kSeq2Seq) return AgentKind::kSeq2SeqCe;
  throw UsageError(
      fmt::format("--agent {}: walks in the graph; --task r2r-ce has seq2seq alone", agent_));
}

void TrainingOptions::leave_out(CLI::App& verb, const std::string& name) {
  CLI::Option* const option = verb.get_option(name);
  std::erase_if(changes_, [option](const Change& change) { return change.option == option; });
  verb.remove_option(option);
}

TrainConfig TrainingOptions::config() const {
  TrainConfig config =
      models::recipe(kind(), models::parse_recipe(recipe_), models::parse_stage(stage_));
  for (const Change& change : changes_) {
    if (change.option->count() == 0) continue;
    if (!change.kinds.empty() &&
        std::ranges::find(change.kinds, config.agent) == change.kinds.end()) {
      throw UsageError(fmt::format("{}: not an option of --agent {}{}", change.option->get_name(),
                                   agent_, task_ == "r2r" ? "" : " --task " + task_));
    }
    if (config.stage == models::Stage::kPretrain &&
        std::ranges::find(kOfWalks, change.option->get_name()) != kOfWalks.end()) {
      throw UsageError(
          fmt::format("{}: not an option of --stage pretrain", change.option->get_name()));
    }
    change.apply(config);
  }
  fix_updates(config, config.seq2seq_ce.set_walks);
  validate(config);
  return config;
}

std::vector<std::string> TrainingOptions::words() const {
  std::vector<std::string> words{"--agent", agent_, "--recipe", recipe_};
  if (stage_ != to_string(models::Stage::kFineTune)) words.insert(words.end(), {"--stage", stage_});
  for (const Change& change : changes_) {
    if (change.option->count() == 0) continue;
    words.push_back(change.option->get_name());
    words.push_back(change.option->results().front());
  }
  return words;
}

}  // namespace enfilade::apps
