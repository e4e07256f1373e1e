#include "enfilade/service/site.h"

#include <fmt/format.h>
#include <algorithm>
#include <numeric>
#include <set>
#include <system_error>
#include <utility>
#include <variant>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/agents/continuous_setup.h"
#include "enfilade/core/check.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::service {
namespace {

namespace fs = std::filesystem;

// Faults of one kind: a file that has one has thousands.
constexpr std::size_t kMostFaults = 20;

bool has_hidden_goal(const tasks::Annotations& annotations) {
  return std::ranges::any_of(annotations.paths, &tasks::PathAnnotation::goal_hidden);
}

/// The data set's file of a split of a benchmark; none if it has none.
std::optional<fs::path> find_file(const dataset::Dataset& data, tasks::Task task,
                                  const std::string& split) {
  try {
    if (task == tasks::Task::kR2r) return data.annotations_file(split);
    return data.annotations_file(task, split);
  } catch (const FileError&) {
    return std::nullopt;
  }
}

std::optional<fs::path> find_file(const dataset::Dataset& data, const Phase& phase) {
  const tasks::Benchmark& benchmark = *phase.benchmark;
  if (!benchmark.continuous()) return find_file(data, benchmark.task, phase.split);
  return agents::find_continuous_split(benchmark, data.folder(), phase.split);
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

/// Whether it is a split of R4R with the paths of another benchmark's secret phase. Its texts are
/// those of two paths, one after the other, and the second starts near the end of the first.
bool tells_ends(const PublicSplit& split, const std::vector<Phase>& phases) {
  using tasks::Task;
  if (split.annotations.task != Task::kR4r) return false;
  bool own = false, others = false;
  for (const Phase& phase : phases) {
    if (!phase.goals_secret() || phase.split != split.annotations.split) continue;
    const bool of_r4r = phase.benchmark->task == Task::kR4r;
    own = own || of_r4r;
    others = others || (!of_r4r && share_paths(*phase.benchmark, tasks::benchmark(Task::kR4r)));
  }
  return others && !own;  // teams need the starts and texts of a phase of R4R
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
  for (const std::string& split : data.splits()) {
    const fs::path file = data.annotations_file(split);
    places.insert(places.end(), {file, file.parent_path()});
  }
  for (const Phase& phase : phases) {
    const auto file = find_file(data, phase);
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

[[noreturn]] void refuse_hidden_goal(const Phase& phase, const std::string& file) {
  throw InvalidInput({{Severity::kError, file, "$", "hidden-goal",
                       "phase " + phase.name + " cannot be scored: a path in it has no goal"}});
}

tasks::EpisodeSet read_graph_goals(const Phase& phase, const dataset::Dataset& data,
                                   std::shared_ptr<const graph::GraphSet> graphs) {
  const tasks::Task task = phase.benchmark->task;
  const auto public_file = [&] {
    return task == tasks::Task::kR2r ? data.annotations_file(phase.split)
                                     : data.annotations_file(task, phase.split);
  };
  const fs::path file = phase.goals_secret() ? phase.annotations : public_file();
  const tasks::Annotations annotations = tasks::load_annotations(file, phase.split, task);
  if (phase.goals_secret()) check_ids_are_silent(annotations);
  tasks::EpisodeSet episodes =
      tasks::make_episodes(annotations, std::move(graphs), tasks::Instructions::kScored,
                           tasks::needs_boxes(annotations) ? &data.objects() : nullptr);
  if (tasks::goals_hidden(episodes)) refuse_hidden_goal(phase, file.string());
  return episodes;
}

ContinuousGoals read_continuous_goals(const Phase& phase, const dataset::Dataset& data,
                                      const graph::GraphSet& graphs) {
  const agents::ContinuousSetup& setup = agents::continuous_setup(*phase.benchmark);
  ContinuousGoals goals;
  if (phase.goals_secret()) {
    goals.episodes = tasks::load_continuous_episodes(phase.annotations, phase.split);
    if (!phase.experts.empty()) goals.experts = tasks::load_expert_walks(phase.experts);
  } else {
    goals.episodes = agents::load_continuous_split(*setup.benchmark, data.folder(), phase.split);
    goals.experts = agents::load_experts_of(*setup.benchmark, data.folder(), phase.split);
  }
  if (tasks::goals_hidden(goals.episodes)) refuse_hidden_goal(phase, goals.episodes.file);
  goals.buildings =
      std::make_shared<const continuous::Buildings>(data.folder() / setup.navigation_folder());
  std::vector<std::size_t> all(goals.episodes.episodes.size());
  std::iota(all.begin(), all.end(), 0U);
  for (const tasks::ContinuousEpisode& one : goals.episodes.episodes) graphs.at(one.scan());
  agents::check_goals(goals.episodes, *goals.buildings, all);
  return goals;
}

}  // namespace

std::size_t count_episodes(const SecretEpisodes& episodes) noexcept {
  const auto* graph = std::get_if<tasks::EpisodeSet>(&episodes);
  if (graph != nullptr) return graph->episodes.size();
  return std::get_if<ContinuousGoals>(&episodes)->episodes.episodes.size();
}

std::shared_ptr<const Site> Site::open(const fs::path& data, std::vector<Phase> phases) {
  const std::shared_ptr<Site> site(new Site);
  const dataset::Dataset set(data);
  site->data_ = set;
  site->graphs_ = set.graphs();
  site->graphs_->load_all();
  site->panoramas_ = set.panoramas();
  site->folder_ = set.folder();
  site->image_folders_ = set.panorama_places().images;
  site->synthetic_ = set.synthetic();
  site->phases_ = std::move(phases);
  site->check_goals_are_elsewhere(set);
  site->read_splits(set);
  site->read_phases(set);
  site->hide_goals();
  site->count_rooms(set);
  return site;
}

void Site::count_rooms(const dataset::Dataset& data) {
  try {
    data.regions_file();
  } catch (const FileError&) {
    return;  // many data sets have none
  }
  const scan::RegionMap& regions = data.regions();
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
    return &data_->objects();
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

void Site::read_splits(const dataset::Dataset& data) {
  for (const tasks::Benchmark& one : tasks::benchmarks()) {
    if (one.continuous()) continue;
    for (const std::string_view name : dataset::kSplits) {
      read_split(data, one.task, std::string(name));
    }
  }
  for (const Phase& phase : phases_) read_split(data, phase.benchmark->task, phase.split);
}

void Site::read_split(const dataset::Dataset& data, tasks::Task task, const std::string& name) {
  const auto file = find_file(data, task, name);
  if (!file || find_split(name, task) != nullptr) return;  // a data set may lack any of the splits
  tasks::Annotations annotations = tasks::load_annotations(*file, name, task);
  tasks::look_up_paths(annotations, *graphs_);  // throws if a path cannot be shown on a plan
  splits_.push_back({std::move(annotations), false});
}

void Site::check_goals_are_elsewhere(const dataset::Dataset& data) const {
  const std::vector<fs::path> served = served_places(data, phases_);
  for (const Phase& phase : phases_) {
    if (!phase.goals_secret()) continue;
    for (const fs::path& secret : {phase.annotations, phase.experts}) {
      if (!secret.empty()) check_is_elsewhere(secret, phase, served);
    }
  }
}

void Site::read_phases(const dataset::Dataset& data) {
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
    if (phase.benchmark->continuous()) {
      secret_.emplace_back(read_continuous_goals(phase, data, *graphs_));
    } else {
      secret_.emplace_back(read_graph_goals(phase, data, graphs_));
    }
  }
}

// The annotations of a secret phase may be in the data set too, by mistake; and what R2R says of a
// path's end tells what REVERIE asks for there.
void Site::hide_goals() {
  std::erase_if(splits_, [this](const PublicSplit& split) { return tells_ends(split, phases_); });
  for (PublicSplit& split : splits_) {
    const bool secret = std::ranges::any_of(phases_, [&split](const Phase& phase) {
      return phase.goals_secret() && phase.split == split.annotations.split &&
             share_paths(*phase.benchmark, tasks::benchmark(split.annotations.task));
    });
    if (secret) std::ranges::for_each(split.annotations.paths, hide_goal);
    split.goals_hidden = has_hidden_goal(split.annotations);
  }
}

const PublicSplit* Site::find_split(std::string_view name, tasks::Task task) const noexcept {
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
