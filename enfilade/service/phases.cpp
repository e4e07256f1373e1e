#include "enfilade/service/phases.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <iterator>
#include <optional>
#include <ranges>
#include <set>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/gzip.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/service/detail/fields.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/tasks/benchmark.h"

namespace enfilade::service {
namespace {

constexpr int kMostPerDay = 1000;
constexpr int kMostInAll = 1'000'000;
constexpr int kMostTeams = 10'000;
constexpr std::size_t kMostPhases = 100;
// A phase has 15 fields: 30 names and values, and its place in the list.
constexpr json::Limits kFileLimits{kMostPhases * 40, 8};
constexpr std::size_t kShownIds = 3;
// Default for secret goals. Twenty submissions are enough for the runs of a paper and its
// ablations; each more lets a team learn more of the goals.
constexpr int kPerTeam = 20;
// Teams that may share an address: a laboratory has one for all of its machines.
constexpr int kTeamsOfAnAddress = 5;
// A finer step than a thousandth rounds nothing at the size of R2R's splits.
constexpr double kLeastStep = 0.001;
constexpr double kMostStep = 0.5;

bool is_scores(std::string_view text) { return find_enum<Scores>(text).has_value(); }
constexpr std::size_t kLongestRules = 20'000;
bool is_rules(std::string_view text) { return detail::is_prose(text, kLongestRules); }
bool is_any(std::string_view /*text*/) { return true; }
bool is_time(std::string_view text) { return detail::parse_time(text).has_value(); }

std::string nonempty(const detail::Fields& fields, std::string_view name, json::Faults& faults) {
  const auto value = json::string(fields[name], fields.path(name), faults);
  if (value && value->empty()) faults.error(fields.path(name), "empty-text", "must not be empty");
  return std::string(value.value_or(""));
}

/// "scores", or its default: goals that are secret stay so unless the file says otherwise.
Scores read_scores(const detail::Fields& fields, bool secret, json::Faults& faults) {
  const Scores otherwise = secret ? Scores::kAfterEnd : Scores::kPublic;
  if (!fields.has("scores")) return otherwise;
  const auto scores = find_enum<Scores>(fields.text(
      "scores", is_scores, R"("public", "after-end", "ladder" or "hidden")", "bad-scores"));
  if (secret && scores == Scores::kPublic) {
    faults.error(
        fields.path("scores"), "scores-tell-goals",
        "\"public\" scores would tell where the secret goals are; write \"after-end\" "
        "(one row for each team when the phase has ended), \"ladder\" (only what beats the "
        "team's best) or \"hidden\"");
  }
  if (!secret && (scores == Scores::kAfterEnd || scores == Scores::kLadder)) {
    faults.error(fields.path("scores"), "scores-of-open-goals",
                 "this is for secret goals, and the phase has no \"annotations\" of its own; write "
                 "\"public\" or \"hidden\"");
  }
  return scores.value_or(otherwise);
}

/// A limit over all time. \param otherwise 0: none
std::optional<int> read_total(const detail::Fields& fields, std::string_view name, int otherwise) {
  const int most = fields.integer(name, 1, kMostInAll, otherwise);
  return most == 0 ? std::nullopt : std::optional(most);
}

void read_limits(const detail::Fields& fields, Phase& phase) {
  const bool secret = phase.goals_secret();
  phase.per_day = fields.integer("per_day", 1, kMostPerDay, phase.per_day);
  phase.per_address_day =
      fields.integer("per_address_day", 1, kMostInAll, kTeamsOfAnAddress * phase.per_day);
  phase.per_team = read_total(fields, "per_team", secret ? kPerTeam : 0);
  phase.per_address =
      read_total(fields, "per_address", secret ? kTeamsOfAnAddress * *phase.per_team : 0);
  phase.teams = fields.integer("teams", 1, kMostTeams, phase.teams);
}

/// One of several entries, by its name; null, reported, if the text names none.
template <class Range>
auto read_choice(const detail::Fields& fields, std::string_view name, Range allowed,
                 const char* code, json::Faults& faults) {
  const auto name_of = [](const auto& one) { return std::string_view(one.name); };
  const std::string text = fields.text(name, is_any, "", code);
  const auto found = std::ranges::find(allowed, std::string_view(text), name_of);
  if (found != allowed.end()) return &*found;
  faults.error(fields.path(name), code,
               fmt::format("{:?}, not one of {}", text.substr(0, detail::kQuoted),
                           fmt::join(allowed | std::views::transform(name_of), ", ")));
  return static_cast<decltype(&*found)>(nullptr);
}

/// "task", "scorer" and "primary", each of which says what is allowed in the next.
void read_task(const detail::Fields& fields, Phase& phase, json::Faults& faults) {
  if (fields.has("task")) {
    const auto* task = read_choice(fields, "task", tasks::benchmarks(), "unknown-task", faults);
    if (task == nullptr) return;
    phase.benchmark = task;
  }
  const auto scorers = phase.benchmark->scorers;
  phase.scorer = &scorers.front();
  if (fields.has("scorer")) {
    phase.scorer = read_choice(fields, "scorer", scorers, "unknown-scorer", faults);
    if (phase.scorer == nullptr) return;
  }
  phase.primary = phase.measures().front().name;
  if (!fields.has("primary")) return;
  const auto may_rank = [](const tasks::Measure& measure) {
    return measure.better == tasks::Better::kHigher;
  };
  const auto* primary = read_choice(
      fields, "primary", phase.measures() | std::views::filter(may_rank), "bad-primary", faults);
  if (primary != nullptr) phase.primary = primary->name;
}

/// "experts": walks of a continuous split whose goals are secret. \pre the task is read
void read_experts(const detail::Fields& fields, Phase& phase, json::Faults& faults) {
  if (!fields.has("experts")) return;
  phase.experts = nonempty(fields, "experts", faults);
  if (phase.benchmark->continuous() && phase.goals_secret()) return;
  faults.error(fields.path("experts"), "experts-without-use",
               "experts' walks are for a task in continuous space whose phase has \"annotations\" "
               "of its own; with open goals the data set's are used");
}

/// A part of URLs that is an id, too: no - at its beginning.
std::string read_name(const detail::Fields& fields, std::string_view name, json::Faults& faults) {
  const std::string text =
      fields.text(name, detail::is_name, "1 to 40 of a-z, 0-9, - and _", "bad-name");
  if (detail::is_name(text)) json::id(fields[name], fields.path(name), faults);
  return text;
}

/// What would change nothing for open goals. Whoever writes it means secret ones.
void check_use(const detail::Fields& fields, const Phase& phase, json::Faults& faults) {
  if (phase.goals_secret()) return;
  for (const char* name : {"step", "teams"}) {
    if (!fields.has(name)) continue;
    faults.error(fields.path(name), "field-without-use",
                 "this is for secret goals, and the phase has no \"annotations\" of its own");
  }
}

/// Reads one entry of "phases"; none if it has faults.
std::optional<Phase> read_phase(json::Element element, const json::Path& path,
                                json::Faults& faults) {
  const std::size_t before = faults.errors();
  const detail::Fields fields(
      element, path, faults, {"name", "split"},
      {"title", "rules", "task", "scorer", "annotations", "experts", "scores", "primary", "step",
       "ends", "per_day", "per_team", "per_address_day", "per_address", "teams"});
  // A misspelled field is the reason of other faults, which would hide it.
  if (!fields.refuse_others() || !fields.complete()) return std::nullopt;
  Phase phase;
  phase.name = read_name(fields, "name", faults);
  phase.split = read_name(fields, "split", faults);
  phase.title = fields.has("title") ? nonempty(fields, "title", faults) : phase.name;
  if (fields.has("rules")) {
    phase.rules = fields.text("rules", is_rules, "1 to 20000 characters of Markdown", "bad-text");
  }
  if (fields.has("annotations")) phase.annotations = nonempty(fields, "annotations", faults);
  phase.scores = read_scores(fields, fields.has("annotations"), faults);
  read_task(fields, phase, faults);
  phase.split = std::string(tasks::split_name(*phase.benchmark, phase.split));
  read_experts(fields, phase, faults);
  check_use(fields, phase, faults);
  if (fields.has("step")) phase.step = fields.number("step", kLeastStep, kMostStep);
  if (fields.has("ends")) {
    phase.ends = detail::parse_time(
        fields.text("ends", is_time, "a time in UTC like \"2027-03-31T23:59:59Z\"", "bad-time"));
  }
  read_limits(fields, phase);
  if (faults.errors() != before) return std::nullopt;
  return phase;
}

/// A split with open goals in one phase and secret ones in another would have no secret goals.
void check_openness(const std::vector<Phase>& phases, const json::Path& list,
                    json::Faults& faults) {
  for (std::size_t k = 0; k < phases.size(); ++k) {
    const Phase* twin = find_secret(phases, phases[k].split, *phases[k].benchmark);
    if (phases[k].goals_secret() || twin == nullptr) continue;
    const json::Path path(list, k);
    faults.error(json::Path(path, "split"), "open-and-secret",
                 fmt::format("{:?} has secret goals in phase {:?}; give this phase \"annotations\" "
                             "too",
                             phases[k].split, twin->name));
  }
}

/// A split's ids by what identifies an episode in results. Lines of RxR without a path_id have only
/// the last part.
std::set<std::string> ids_of(const tasks::Split& split) {
  const bool of_rxr = split.benchmark().name == "rxr";
  std::set<std::string> ids;
  for (std::size_t k = 0; k < split.size(); ++k) {
    const std::string id = split.id(k);
    ids.insert(of_rxr ? id.substr(id.rfind('_') + 1) : id);
  }
  return ids;
}

/// "2 only here, such as "1_0", "1_1"": ids that the other split lacks; empty if there are none.
std::string only_in(const std::set<std::string>& ids, const std::set<std::string>& others,
                    std::string_view where) {
  std::vector<std::string> only;
  std::ranges::set_difference(ids, others, std::back_inserter(only));
  if (only.empty()) return {};
  std::vector<std::string> shown;
  for (const std::string& id : only | std::views::take(kShownIds)) shown.push_back(quote(id));
  return fmt::format("; {} of {} only {}, such as {}", only.size(), ids.size(), where,
                     fmt::join(shown, ", "));
}

}  // namespace

void check_public_file(const Phase& phase, const tasks::Split& goals,
                       const dataset::Dataset& data) {
  if (!phase.goals_secret()) return;
  const auto refuse = [&phase](const char* code, std::string text) {
    throw InvalidInput(
        {{Severity::kError, phase.annotations.string(), "$", code, std::move(text)}});
  };
  const auto file = data.find_episodes(*phase.benchmark, phase.split);
  if (!file) {
    refuse("no-public-file",
           fmt::format("phase {}: {} has no file of split {:?} with starts and instructions for "
                       "teams; {} is expected",
                       phase.name, data.folder().string(), phase.split,
                       tasks::episode_places(*phase.benchmark, phase.split).front().string()));
  }
  const auto secret = ids_of(goals);
  const auto open = ids_of(data.split(*phase.benchmark, phase.split, {.experts = false}));
  const std::string differ = only_in(secret, open, "here") + only_in(open, secret, "there");
  if (differ.empty()) return;
  refuse("ids-differ", fmt::format("phase {}: the ids are not those of the public file {}{}",
                                   phase.name, file->string(), differ));
}

const tasks::Measure& Phase::primary_measure() const {
  const tasks::Measure* measure = tasks::find_measure(measures(), primary);
  EN_CHECK(measure != nullptr);
  return *measure;
}

const Phase* find_secret(std::span<const Phase> phases, std::string_view split,
                         const tasks::Benchmark& benchmark) noexcept {
  const auto found = std::ranges::find_if(phases, [&](const Phase& phase) {
    return phase.goals_secret() && phase.split == split && share_paths(*phase.benchmark, benchmark);
  });
  return found == phases.end() ? nullptr : &*found;
}

std::vector<Phase> parse_phases(std::string_view text, const std::string& file) {
  json::Faults faults(file);
  const json::Path root;
  const json::Path list_path(root, "phases");
  if (const std::string excess = json::excess(text, kFileLimits); !excess.empty()) {
    faults.error(root, "too-large", fmt::format("{}; {} phases are allowed", excess, kMostPhases));
    faults.throw_if_errors();
  }
  const json::Document document = json::Document::parse(text, file);
  const detail::Fields fields(document.root(), root, faults, {"phases"});
  fields.refuse_others();
  const auto list =
      fields.complete() ? json::array(fields["phases"], list_path, faults) : std::nullopt;
  if (list && list->size() > kMostPhases) {
    faults.error(list_path, "too-many",
                 fmt::format("{} phases; {} are allowed", list->size(), kMostPhases));
  }
  faults.throw_if_errors();
  std::vector<Phase> phases;
  std::set<std::string> names;
  std::size_t k = 0;
  for (const json::Element element : *list) {
    const json::Path path(list_path, k++);
    auto phase = read_phase(element, path, faults);
    if (!phase) continue;
    if (!names.insert(phase->name).second) {
      faults.error(path, "repeated-name", fmt::format("{:?} is there twice", phase->name));
    }
    phases.push_back(std::move(*phase));
  }
  faults.throw_if_errors();  // only then an entry's place in `phases` is its place in the file
  check_openness(phases, list_path, faults);
  faults.throw_if_errors();
  return phases;
}

std::vector<Phase> load_phases(const std::filesystem::path& file) {
  std::vector<Phase> phases = parse_phases(read_text_file(file), file.string());
  for (Phase& phase : phases) {
    if (phase.goals_secret()) phase.annotations = file.parent_path() / phase.annotations;
    if (!phase.experts.empty()) phase.experts = file.parent_path() / phase.experts;
  }
  return phases;
}

}  // namespace enfilade::service
