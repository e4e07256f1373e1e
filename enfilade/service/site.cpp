#include "enfilade/service/site.h"

#include <fmt/format.h>
#include <algorithm>
#include <iterator>
#include <numeric>
#include <set>
#include <system_error>
#include <utility>
#include <variant>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/agents/continuous_setup.h"
#include "enfilade/core/check.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/objects.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::service {
namespace {

namespace fs = std::filesystem;

// Faults of one kind: a file that has one has thousands.
constexpr std::size_t kMostFaults = 20;

bool has_hidden_goal(const tasks::Annotations& annotations) {
  return std::ranges::any_of(annotations.paths, &tasks::PathAnnotation::goal_hidden);
}

/// Everything of a path that could tell where it leads, or what is asked for there, goes.
void hide_goal(tasks::PathAnnotation& path) {
  path.path.resize(1);
  path.distance.reset();
  const bool id_tells = std::holds_alternative<tasks::NamedObject>(path.goal);
  if (id_tells) path.id.clear();  // "1357_66" of path 1357 and object 66
  path.goal = tasks::HiddenGoal();
  path.group.reset();  // paths of one group end at one place, or are joined from the same ones
  for (tasks::InstructionDetails& details : path.details) {
    if (id_tells) details.id.clear();
    for (tasks::SubInstruction& part : details.parts) part.places.reset();
  }
}

/// Whether an id is "<path>_<object>" or, as lines of single instructions have it,
/// "<path>_<object>_<k>".
bool id_names_object(std::string_view id, std::int64_t object) {
  const std::string end = fmt::format("_{}", object);
  return id.ends_with(end) || id.substr(0, id.rfind('_')).ends_with(end);
}

/// REVERIE's ids may name the object, and teams have to know the ids.
void check_ids_are_silent(const tasks::Annotations& annotations) {
  std::vector<Diagnostic> faults;
  for (std::size_t k = 0; k < annotations.paths.size(); ++k) {
    const tasks::PathAnnotation& path = annotations.paths[k];
    const auto* object = std::get_if<tasks::NamedObject>(&path.goal);
    if (object == nullptr || !id_names_object(path.id, object->id)) continue;
    faults.push_back({Severity::kError, annotations.file, fmt::format("$[{}].id", k),
                      "id-tells-object",
                      fmt::format("{:?} names the object that is secret; write a number, as the "
                                  "test split has it",
                                  path.id)});
    if (faults.size() == kMostFaults) break;
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
}

/// Paths of the instances of CVDN with which dialogues begin: later ones start on the way.
std::vector<tasks::ReferencePath> first_of_games(const tasks::Annotations& annotations,
                                                 std::span<const tasks::ReferencePath> paths) {
  std::vector<tasks::ReferencePath> first;
  for (std::size_t k = 0; k < paths.size(); ++k) {
    const auto& details = annotations.paths[k].details;
    const bool later =
        !details.empty() && std::ranges::any_of(details.front().turns,
                                                [](const auto& turn) { return turn.nav_step > 0; });
    if (!later) first.push_back(paths[k]);
  }
  return first;
}

std::string share_text(const SharedKeys& keys) {
  return fmt::format("{} of {}", keys.shared, keys.smaller);
}

/// Absolute and without links; of what cannot be looked up, its name as it is written.
fs::path real_path(const fs::path& path) {
  std::error_code error;
  const fs::path found = fs::weakly_canonical(path, error);
  return error ? fs::absolute(path).lexically_normal() : found;
}

/// The folder of a data set, and what of it may be a link to elsewhere: its parts, and its splits'
/// files.
std::vector<fs::path> served_places(const dataset::Dataset& data,
                                    const std::vector<Phase>& phases) {
  const scan::PanoramaPlaces panoramas = data.panorama_places();
  std::vector<fs::path> places{data.folder(), panoramas.connectivity};
  places.insert(places.end(), panoramas.images.begin(), panoramas.images.end());
  const tasks::Benchmark& r2r = tasks::benchmark(tasks::Task::kR2r);
  for (const std::string& split : data.splits(r2r)) {
    const fs::path file = data.episodes_file(r2r, split);
    places.insert(places.end(), {file, file.parent_path()});
  }
  for (const Phase& phase : phases) {
    const auto file = data.find_episodes(*phase.benchmark, phase.split);
    if (file) places.insert(places.end(), {*file, file->parent_path()});
  }
  std::erase_if(places, [](const fs::path& place) { return place.empty(); });
  std::ranges::transform(places, places.begin(), real_path);
  return places;
}

/// Whether a file is that place, or in that folder. \pre both are real paths
bool is_inside(const fs::path& file, const fs::path& place) {
  return std::ranges::mismatch(place, file).in1 == place.end();
}

void check_is_elsewhere(const fs::path& secret, const Phase& phase,
                        const std::vector<fs::path>& served) {
  // A link inside to a file elsewhere is as bad: it is often followed when a folder is copied.
  const fs::path file = real_path(secret);
  const fs::path name = real_path(secret.parent_path()) / secret.filename();
  for (const fs::path& place : served) {
    if (!is_inside(file, place) && !is_inside(name, place)) continue;
    throw InvalidInput(
        {{Severity::kError, secret.string(), "$", "goals-in-data-set",
          fmt::format("the secret goals of phase {} are in {}, a part of the data set, which "
                      "people copy to others; move them out of it",
                      phase.name, place.string())}});
  }
}

tasks::Split read_on_graph(const Phase& phase, const fs::path& file, const dataset::Dataset& data,
                           std::shared_ptr<const graph::GraphSet> graphs) {
  const auto annotations = tasks::load_annotations(file, phase.split, phase.benchmark->task);
  if (phase.goals_secret()) check_ids_are_silent(annotations);
  return tasks::Split(
      tasks::make_episodes(annotations, std::move(graphs), tasks::Instructions::kScored,
                           tasks::needs_boxes(annotations) ? &data.objects() : nullptr));
}

tasks::Split read_continuous(const Phase& phase, const dataset::Dataset& data) {
  if (!phase.goals_secret()) return data.split(*phase.benchmark, phase.split);
  std::shared_ptr<const tasks::ExpertWalks> experts;
  if (!phase.experts.empty()) {
    experts = std::make_shared<const tasks::ExpertWalks>(tasks::load_expert_walks(phase.experts));
  }
  return {*phase.benchmark,
          std::make_shared<const tasks::ContinuousEpisodes>(
              tasks::load_continuous_episodes(phase.annotations, phase.split)),
          std::move(experts)};
}

SecretEpisodes read_goals(const Phase& phase, const dataset::Dataset& data,
                          const std::shared_ptr<const graph::GraphSet>& graphs) {
  const fs::path file =
      phase.goals_secret() ? phase.annotations : data.episodes_file(*phase.benchmark, phase.split);
  SecretEpisodes read{phase.benchmark->continuous() ? read_continuous(phase, data)
                                                    : read_on_graph(phase, file, data, graphs)};
  if (read.split.goals_hidden()) {
    throw InvalidInput({{Severity::kError, file.string(), "$", "hidden-goal",
                         "phase " + phase.name + " cannot be scored: a path in it has no goal"}});
  }
  const auto& episodes = read.split.continuous();
  if (episodes == nullptr) return read;
  read.buildings = agents::open_buildings(*phase.benchmark, data.folder());
  std::vector<std::size_t> all(read.split.size());
  std::iota(all.begin(), all.end(), 0U);
  for (const tasks::ContinuousEpisode& one : episodes->episodes) graphs->at(one.scan());
  agents::check_goals(*episodes, *read.buildings, all);
  return read;
}

}  // namespace

std::shared_ptr<const Site> Site::open(const fs::path& data, std::vector<Phase> phases) {
  return std::shared_ptr<const Site>(new Site(data, std::move(phases)));
}

Site::Site(const fs::path& data, std::vector<Phase> phases)
    : data_(data),
      graphs_(data_.graphs()),
      panoramas_(data_.panoramas()),
      phases_(std::move(phases)),
      image_folders_(data_.panorama_places().images),
      synthetic_(data_.synthetic()) {
  graphs_->load_all();
  check_goals_are_elsewhere();
  read_splits();
  read_phases();
  hide_goals();
  count_rooms();
}

void Site::count_rooms() {
  try {
    data_.regions_file();
  } catch (const FileError&) {
    return;  // many data sets have none
  }
  const scan::RegionMap& regions = data_.regions();
  for (std::size_t s = 0; s < graphs_->size(); ++s) {
    const graph::NavGraph& graph = graphs_->graph(ScanIndex(s));
    std::set<std::uint32_t> seen;
    for (std::size_t v = 0; v < graph.size(); ++v) {
      const auto region = regions.find(graph.scan(), std::string(graph.id(ViewpointIndex(v))));
      if (region) seen.insert(*region);
    }
    rooms_.push_back(seen.size());
  }
}

const tasks::ObjectBoxes* Site::objects() const {
  const std::scoped_lock lock(objects_mutex_);
  if (broken_objects_) std::rethrow_exception(broken_objects_);
  try {
    return &data_.objects();
  } catch (const FileError&) {
    return nullptr;  // many data sets have none
  } catch (const InvalidInput&) {
    broken_objects_ = std::current_exception();
    throw;
  }
}

std::optional<std::size_t> Site::rooms(ScanIndex scan) const {
  if (rooms_.empty() || rooms_[scan.at()] == 0) return std::nullopt;
  return rooms_[scan.at()];
}

void Site::read_splits() {
  for (const tasks::Benchmark& one : tasks::benchmarks()) {
    if (one.continuous()) continue;
    for (const std::string_view name : tasks::benchmark(tasks::Task::kR2r).splits) {
      read_split(one.task, std::string(name));
    }
  }
  for (const Phase& phase : phases_) read_split(phase.benchmark->task, phase.split);
}

void Site::read_split(tasks::Task task, const std::string& name) {
  const auto file = data_.find_episodes(tasks::benchmark(task), name);
  if (!file || find_split(name, task) != nullptr) return;  // a data set may lack any of the splits
  tasks::Annotations annotations = tasks::load_annotations(*file, name, task);
  tasks::look_up_paths(annotations, *graphs_);  // throws if a path cannot be shown on a plan
  splits_.push_back({std::move(annotations), false});
}

void Site::check_goals_are_elsewhere() const {
  const std::vector<fs::path> served = served_places(data_, phases_);
  for (const Phase& phase : phases_) {
    if (!phase.goals_secret()) continue;
    for (const fs::path& secret : {phase.annotations, phase.experts}) {
      if (!secret.empty()) check_is_elsewhere(secret, phase, served);
    }
  }
}

void Site::read_phases() {
  if (phases_.empty()) {
    for (const PublicSplit& split : splits_) {
      const std::string& name = split.annotations.split;
      if (name == "train" || has_hidden_goal(split.annotations)) continue;
      if (split.annotations.task != tasks::Task::kR2r) continue;
      Phase& phase = phases_.emplace_back();
      phase.name = phase.title = phase.split = name;
    }
  }
  for (const Phase& phase : phases_) {
    SecretEpisodes& read = secret_.emplace_back(read_goals(phase, data_, graphs_));
    if (phase.goals_secret()) read.keys = goal_keys(read.split, *graphs_);
    check_public_file(phase, read.split, data_);
  }
}

// The annotations of a secret phase may be in the data set too, by mistake. So may another
// benchmark's with the same goals, and what R2R says of a path's end tells what REVERIE asks for
// there.
void Site::hide_goals() {
  std::set<std::string, std::less<>> scans;  // of secret goals
  for (std::size_t k = 0; k < phases_.size(); ++k) {
    if (!phases_[k].goals_secret()) continue;
    const tasks::Split& split = secret_[k].split;
    for (std::size_t e = 0; e < split.size(); ++e) scans.insert(split.path_size(e).scan);
  }
  std::vector<PublicSplit> kept;
  for (PublicSplit& split : splits_) {
    if (!scans.empty() && !hide_in(split, scans)) continue;
    split.goals_hidden = has_hidden_goal(split.annotations);
    kept.push_back(std::move(split));
  }
  splits_ = std::move(kept);
  if (scans.empty()) return;
  look_at_continuous();
  check_open_phases();
}

/// Takes secret goals out of a split. \returns whether the rest of it may be public
bool Site::hide_in(PublicSplit& split, const std::set<std::string, std::less<>>& scans) {
  tasks::Annotations& annotations = split.annotations;
  const tasks::Benchmark& benchmark = tasks::benchmark(annotations.task);
  const auto paths = tasks::look_up_paths(annotations, *graphs_);
  // R4R's training split has some 20 million pairs, none of them in scans of a test split.
  std::vector<tasks::ReferencePath> near;
  std::ranges::copy_if(paths, std::back_inserter(near), [&](const tasks::ReferencePath& path) {
    return scans.contains(graphs_->graph(path.scan).scan());
  });
  const SharedSecret shared = find_shared(goal_keys(near, annotations.task, *graphs_));
  const std::string name = fmt::format("{} {}", benchmark.name, annotations.split);
  if (const auto reason = reason_to_leave_out(annotations, paths, shared); !reason.empty()) {
    notices_.push_back(fmt::format("{} is left out: {}", name, reason));
    return false;
  }
  const Phase* named = find_secret(phases_, annotations.split, benchmark);
  if (shared.keys.shared > 0) {
    const bool hidden = named != nullptr || shared.keys.tells();
    notices_.push_back(fmt::format("{} {}: {} goals are secret in phase {}{} ({})", name,
                                   hidden ? "is shown without goals" : "is shown whole",
                                   share_text(shared.keys), shared.phase->name,
                                   hidden ? ", and the data set has them" : ", less than a tenth",
                                   annotations.file));
  }
  if (named != nullptr || shared.keys.tells()) std::ranges::for_each(annotations.paths, hide_goal);
  return true;
}

/// Why starts and texts alone give secret ends away; empty where they do not.
std::string Site::reason_to_leave_out(const tasks::Annotations& annotations,
                                      std::span<const tasks::ReferencePath> paths,
                                      const SharedSecret& shared) const {
  const tasks::Benchmark& benchmark = tasks::benchmark(annotations.task);
  const bool own = std::ranges::any_of(phases_, [&](const Phase& phase) {
    return phase.split == annotations.split && phase.benchmark == &benchmark;
  });
  if (own) return {};  // teams need its starts and texts
  if (benchmark.joins_paths) {
    const Phase* named = find_secret(phases_, annotations.split, benchmark);
    if (named == nullptr && shared.keys.tells()) named = shared.phase;
    // Its texts are those of two paths, and the second starts near the end of the first.
    if (named == nullptr) return {};
    return fmt::format("its joined texts tell secret goals of phase {}", named->name);
  }
  if (!benchmark.starts_between) return {};
  const GoalKeys starts = start_keys(first_of_games(annotations, paths), *graphs_);
  for (const Phase& phase : phases_) {
    const auto& secret = secret_episodes(phase).split.on_graph();
    if (!phase.goals_secret() || secret == nullptr) continue;
    const SharedKeys same = shared_keys(starts, start_keys(secret->paths, *graphs_));
    if (!same.tells()) continue;
    return fmt::format("{} dialogues begin where secret paths of phase {} do, and go on along them",
                       share_text(same), phase.name);
  }
  return {};
}

/// Says which continuous files have secret goals. Pages compare again what they show. The training
/// splits are large, and left to the pages.
void Site::look_at_continuous() {
  for (const tasks::Benchmark& benchmark : tasks::benchmarks()) {
    if (!benchmark.continuous()) continue;
    std::set<std::string> names(benchmark.splits.begin(), benchmark.splits.end());
    for (const Phase& phase : phases_) names.insert(phase.split);
    names.erase("train");
    for (const std::string& name : names) {
      if (!data_.has_split(benchmark, name)) continue;
      SharedSecret shared;
      try {
        const auto split = data_.split(benchmark, name, {.experts = false});
        shared = find_shared(goal_keys(split, *graphs_));
      } catch (const Error&) {
        continue;  // told where it is needed
      }
      if (!shared.keys.tells()) continue;
      notices_.push_back(
          fmt::format("{} {} is shown without goals: {} goals are secret in phase {}, and the data "
                      "set has them "
                      "({})",
                      benchmark.name, name, share_text(shared.keys), shared.phase->name,
                      data_.episodes_file(benchmark, name).string()));
    }
  }
}

void Site::check_open_phases() const {
  for (std::size_t k = 0; k < phases_.size(); ++k) {
    if (phases_[k].goals_secret()) continue;
    const SharedSecret shared = find_shared(goal_keys(secret_[k].split, *graphs_));
    if (!shared.keys.tells()) continue;
    throw InvalidInput(
        {{Severity::kError, data_.episodes_file(*phases_[k].benchmark, phases_[k].split).string(),
          "$", "open-and-secret",
          fmt::format("phase {} has open goals, and {} are secret in phase {}; give this phase "
                      "\"annotations\" too, or leave one of them out",
                      phases_[k].name, share_text(shared.keys), shared.phase->name)}});
  }
}

SharedSecret Site::find_shared(const GoalKeys& keys) const {
  SharedSecret most;
  for (std::size_t k = 0; k < phases_.size(); ++k) {
    const SharedKeys found = shared_keys(keys, secret_[k].keys);
    if (found.shared * most.keys.smaller > most.keys.shared * found.smaller ||
        (most.phase == nullptr && found.shared > 0)) {
      most = {&phases_[k], found};
    }
  }
  return most;
}

const PublicSplit* Site::find_split(std::string_view name, tasks::Task task) const noexcept {
  name = tasks::split_name(tasks::benchmark(task), name);
  const auto found = std::ranges::find_if(splits_, [name, task](const PublicSplit& split) {
    return split.annotations.split == name && split.annotations.task == task;
  });
  return found == splits_.end() ? nullptr : &*found;
}

const Phase* Site::find_phase(std::string_view name) const noexcept {
  const auto found = std::ranges::find(phases_, name, &Phase::name);
  return found == phases_.end() ? nullptr : &*found;
}

const SecretEpisodes& Site::secret_episodes(const Phase& phase) const {
  const auto k = static_cast<std::size_t>(&phase - phases_.data());
  EN_CHECK_LT(k, phases_.size());
  return secret_[k];
}

}  // namespace enfilade::service
