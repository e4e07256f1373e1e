#include "enfilade/service/site.h"

#include <fmt/format.h>
#include <algorithm>
#include <set>
#include <system_error>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/tasks/score.h"

namespace enfilade::service {
namespace {

namespace fs = std::filesystem;

bool has_hidden_goal(const tasks::Annotations& annotations) {
  return std::ranges::any_of(annotations.paths, &tasks::PathAnnotation::goal_hidden);
}

/// Absolute and without links; of what cannot be looked up, its name as it is written.
fs::path real_path(const fs::path& path) {
  std::error_code error;
  const fs::path found = fs::weakly_canonical(path, error);
  return error ? fs::absolute(path).lexically_normal() : found;
}

/// The folder of a data set, and what of it may be a link to elsewhere: its parts, and its splits'
/// files.
std::vector<fs::path> served_places(const dataset::Dataset& data) {
  const scan::PanoramaPlaces panoramas = data.panorama_places();
  std::vector<fs::path> places{data.folder(), panoramas.connectivity};
  places.insert(places.end(), panoramas.images.begin(), panoramas.images.end());
  for (const std::string& split : data.splits()) {
    const fs::path file = data.annotations_file(split);
    places.insert(places.end(), {file, file.parent_path()});
  }
  std::erase_if(places, [](const fs::path& place) { return place.empty(); });
  std::ranges::transform(places, places.begin(), real_path);
  return places;
}

/// Whether a file is that place, or in that folder. \pre both are real paths
bool is_inside(const fs::path& file, const fs::path& place) {
  return std::ranges::mismatch(place, file).in1 == place.end();
}

}  // namespace

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
  try {
    return &data_->objects();
  } catch (const FileError&) {
    return nullptr;  // many data sets have none
  }
}

std::optional<std::size_t> Site::rooms(ScanIndex scan) const {
  if (rooms_.empty() || rooms_[scan.at()] == 0) return std::nullopt;
  return rooms_[scan.at()];
}

void Site::read_splits(const dataset::Dataset& data) {
  std::vector<std::string> names(dataset::kSplits.begin(), dataset::kSplits.end());
  for (const Phase& phase : phases_) {
    if (std::ranges::find(names, phase.split) == names.end()) names.push_back(phase.split);
  }
  for (const std::string& name : names) {
    if (!data.has_split(name)) continue;  // a data set may lack any of the splits
    tasks::Annotations annotations = data.annotations(name);
    tasks::look_up_paths(annotations, *graphs_);  // throws if a path cannot be shown on a plan
    splits_.push_back({std::move(annotations), false});
  }
}

void Site::check_goals_are_elsewhere(const dataset::Dataset& data) const {
  const std::vector<fs::path> served = served_places(data);
  for (const Phase& phase : phases_) {
    if (!phase.goals_secret()) continue;
    // A link inside to a file elsewhere is as bad: it is often followed when a folder is copied.
    const fs::path file = real_path(phase.annotations);
    const fs::path name = real_path(phase.annotations.parent_path()) / phase.annotations.filename();
    for (const fs::path& place : served) {
      if (!is_inside(file, place) && !is_inside(name, place)) continue;
      throw InvalidInput(
          {{Severity::kError, phase.annotations.string(), "$", "goals-in-data-set",
            fmt::format("the secret goals of phase {} are in {}, a part of the data set, which "
                        "people copy to others; move them out of it",
                        phase.name, place.string())}});
    }
  }
}

void Site::read_phases(const dataset::Dataset& data) {
  if (phases_.empty()) {
    for (const PublicSplit& split : splits_) {
      const std::string& name = split.annotations.split;
      if (name == "train" || has_hidden_goal(split.annotations)) continue;
      Phase& phase = phases_.emplace_back();
      phase.name = phase.title = phase.split = name;
    }
  }
  for (const Phase& phase : phases_) {
    const fs::path file =
        phase.goals_secret() ? phase.annotations : data.annotations_file(phase.split);
    secret_.push_back(tasks::make_episodes(tasks::load_annotations(file, phase.split), graphs_));
    if (tasks::goals_hidden(secret_.back())) {
      throw InvalidInput({{Severity::kError, file.string(), "$", "hidden-goal",
                           "phase " + phase.name + " cannot be scored: a path in it has no goal"}});
    }
  }
}

// The annotations of a secret phase may be in the data set too, by mistake.
void Site::hide_goals() {
  for (PublicSplit& split : splits_) {
    const bool secret = std::ranges::any_of(phases_, [&split](const Phase& phase) {
      return phase.goals_secret() && phase.split == split.annotations.split;
    });
    if (secret) {
      for (tasks::PathAnnotation& path : split.annotations.paths) {
        path.path.resize(1);
        path.distance.reset();
      }
    }
    split.goals_hidden = has_hidden_goal(split.annotations);
  }
}

const PublicSplit* Site::find_split(std::string_view name) const noexcept {
  const auto found = std::ranges::find_if(
      splits_, [name](const PublicSplit& split) { return split.annotations.split == name; });
  return found == splits_.end() ? nullptr : &*found;
}

const Phase* Site::find_phase(std::string_view name) const noexcept {
  const auto found = std::ranges::find(phases_, name, &Phase::name);
  return found == phases_.end() ? nullptr : &*found;
}

const tasks::EpisodeSet& Site::secret_episodes(const Phase& phase) const {
  const auto k = static_cast<std::size_t>(&phase - phases_.data());
  EN_CHECK_LT(k, phases_.size());
  return secret_[k];
}

}  // namespace enfilade::service
