#include "enfilade/service/site.h"

#include <algorithm>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/r2r/score.h"

namespace enfilade::service {
namespace {

namespace fs = std::filesystem;

bool has_hidden_goal(const r2r::Annotations& annotations) {
  return std::ranges::any_of(annotations.paths, &r2r::PathAnnotation::goal_hidden);
}

}  // namespace

std::shared_ptr<const Site> Site::open(const fs::path& data, std::vector<Phase> phases) {
  const std::shared_ptr<Site> site(new Site);
  const dataset::Dataset set(data);
  site->graphs_ = set.graphs();
  site->graphs_->load_all();
  site->panoramas_ = set.panoramas();
  site->synthetic_ = set.synthetic();
  site->phases_ = std::move(phases);
  site->read_splits(set);
  site->read_phases(set);
  site->hide_goals();
  return site;
}

void Site::read_splits(const dataset::Dataset& data) {
  std::vector<std::string> names(dataset::kSplits.begin(), dataset::kSplits.end());
  for (const Phase& phase : phases_) {
    if (std::ranges::find(names, phase.split) == names.end()) names.push_back(phase.split);
  }
  for (const std::string& name : names) {
    if (!data.has_split(name)) continue;  // a data set may lack any of the splits
    r2r::Annotations annotations = data.annotations(name);
    r2r::look_up_paths(annotations, *graphs_);  // throws if a path cannot be shown on a plan
    splits_.push_back({std::move(annotations), false});
  }
}

void Site::read_phases(const dataset::Dataset& data) {
  if (phases_.empty()) {
    for (const PublicSplit& split : splits_) {
      const std::string& name = split.annotations.split;
      if (name == "train" || has_hidden_goal(split.annotations)) continue;
      phases_.push_back({name, name, name, {}, Scores::kPublic, 10});
    }
  }
  for (const Phase& phase : phases_) {
    const fs::path file =
        phase.goals_secret() ? phase.annotations : data.annotations_file(phase.split);
    secret_.push_back(r2r::make_episodes(r2r::load_annotations(file, phase.split), graphs_));
    if (r2r::goals_hidden(secret_.back())) {
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
      for (r2r::PathAnnotation& path : split.annotations.paths) {
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

const r2r::EpisodeSet& Site::secret_episodes(const Phase& phase) const {
  const auto k = static_cast<std::size_t>(&phase - phases_.data());
  EN_CHECK_LT(k, phases_.size());
  return secret_[k];
}

}  // namespace enfilade::service
