#include "apps/enfilade/learning/training_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string_view>
#include <variant>

#include "apps/common/program.h"

namespace enfilade::apps {
namespace {

using models::AgentKind;
using models::TrainConfig;
using models::TrainOption;

constexpr std::array<AgentKind, 5> kKinds{AgentKind::kSeq2Seq, AgentKind::kPanoramic,
                                          AgentKind::kDuet, AgentKind::kSpeaker,
                                          AgentKind::kSeq2SeqCe};

// For rollouts of the agent: not for pretraining.
constexpr std::array<std::string_view, 3> kOfRollouts{"--feedback", "--map-teacher",
                                                      "--teacher-weight"};

// The row of an agent's flag; null: it does not have the flag.
const TrainOption* row_of(const std::vector<const TrainOption*>& rows, AgentKind kind) {
  const auto found =
      std::ranges::find_if(rows, [kind](const TrainOption* row) { return row->has_flag(kind); });
  return found == rows.end() ? nullptr : *found;
}

// "(default: 100; panoramic 64, duet 8)"; empty if the help has it, as for names.
std::string defaults(const std::vector<const TrainOption*>& rows) {
  std::vector<std::string> texts;
  std::string first;
  for (const AgentKind kind : kKinds) {
    const TrainOption* const row = row_of(rows, kind);
    if (row == nullptr) continue;
    TrainConfig config = models::recipe(kind);
    const models::OptionField field = row->field(config);
    std::string text;
    if (const auto* const real = std::get_if<double*>(&field)) text = fmt::format("{}", **real);
    if (const auto* const whole = std::get_if<std::size_t*>(&field)) {
      text = fmt::format("{}", **whole);
    }
    if (text.empty()) return {};
    if (first.empty()) first = text;
    if (text != first) texts.push_back(fmt::format("{} {}", to_string(kind), text));
  }
  return fmt::format(" (default: {}{}{})", first, texts.empty() ? "" : "; ",
                     fmt::join(texts, ", "));
}

// The value of one option, of its field's type.
struct Value {
  std::string name;
  std::uint64_t whole = 0;
  double real = 0;

  void write_to(const TrainOption& row, const models::OptionField& field) const {
    if (const auto* const to = std::get_if<double*>(&field)) **to = real;
    if (const auto* const to = std::get_if<std::size_t*>(&field)) **to = whole;
    if (const auto* const to = std::get_if<std::optional<std::size_t>*>(&field)) **to = whole;
    if (const auto* const to = std::get_if<models::NamedField>(&field)) {
      to->parse(to->value, row.words(), name);
    }
  }
};

}  // namespace

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
  add_size(verb);
  std::vector<Rows> flags;
  for (const auto& table : {models::network_options(), models::training_options()}) {
    for (const TrainOption& row : table) {
      if (row.flag.name.empty()) continue;
      const auto same = std::ranges::find_if(
          flags, [&row](const Rows& rows) { return rows.front()->flag.name == row.flag.name; });
      (same == flags.end() ? flags.emplace_back() : *same).push_back(&row);
    }
  }
  for (const Rows& rows : flags) add(verb, rows);
}

void TrainingOptions::add_size(CLI::App& verb) {
  const auto size = std::make_shared<std::string>();
  CLI::Option* const option = verb.add_option(
      "--size", *size, "Sizes of DUET: as published (duet) or small (duet-s) (default: duet)");
  option->check(CLI::IsMember({"duet-s", "duet"}));
  changes_.push_back({option, [](AgentKind kind) { return kind == AgentKind::kDuet; },
                      [size](TrainConfig& config) {
                        const double dropped = config.duet.feature_dropout;  // the stage's
                        config.duet = models::duet_preset(*size);
                        config.duet.feature_dropout = dropped;
                      }});
}

void TrainingOptions::add(CLI::App& verb, const Rows& rows) {
  const TrainOption& first = *rows.front();
  const std::string name(first.flag.name);
  const std::string help = std::string(first.flag.help) + defaults(rows);
  TrainConfig any;
  const models::OptionField field = first.field(any);
  const auto value = std::make_shared<Value>();
  CLI::Option* option = nullptr;
  if (const auto* const named = std::get_if<models::NamedField>(&field)) {
    option = verb.add_option(name, value->name, help)->check(CLI::IsMember(named->names()));
  } else if (std::holds_alternative<double*>(field)) {
    option = verb.add_option(name, value->real, help)->check(finite_number());
  } else {
    option = verb.add_option(name, value->whole, help)->check(whole_number(first.flag.least));
  }
  changes_.push_back({option, [rows](AgentKind kind) { return row_of(rows, kind) != nullptr; },
                      [this, rows, value](TrainConfig& config) {
                        const TrainOption& row = *row_of(rows, config.agent);
                        value->write_to(row, row.field(config));
                        const bool paper = config.agent == AgentKind::kSeq2Seq &&
                                           recipe_ == "published" && row.json == "feedback";
                        if (paper) config.iterations = models::paper_iterations(config.feedback);
                      }});
}

AgentKind TrainingOptions::kind() const {
  const AgentKind kind = models::parse_name<AgentKind>("agent", agent_);
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
  TrainConfig config = models::recipe(kind(), models::parse_name<models::Recipe>("recipe", recipe_),
                                      models::parse_name<models::Stage>("stage", stage_));
  for (const Change& change : changes_) {
    if (change.option->count() == 0) continue;
    if (!change.of(config.agent)) {
      throw UsageError(fmt::format("{}: not an option of --agent {}{}", change.option->get_name(),
                                   agent_, task_ == "r2r" ? "" : " --task " + task_));
    }
    if (config.stage == models::Stage::kPretrain &&
        std::ranges::find(kOfRollouts, change.option->get_name()) != kOfRollouts.end()) {
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
