#include "enfilade/service/evaluation/shared_goals.h"

#include <algorithm>
#include <filesystem>
#include <iterator>

#include "enfilade/core/check.h"
#include "enfilade/service/evaluation/leakage.h"

namespace enfilade::service::evaluation {
namespace {

bool share_goals(const Phase* one, const Phase* other) {
  if (!one->goals_secret() || !other->goals_secret()) return one == other;
  if (one->split == other->split && share_paths(*one->benchmark, *other->benchmark)) return true;
  std::error_code error;  // the files were read before; one that is gone now equals none
  return std::filesystem::equivalent(one->annotations, other->annotations, error);
}

}  // namespace

SharedGoals::SharedGoals(const Site& site) {
  for (const Phase& phase : site.phases()) {
    Group joined{{&phase},
                 phase.goals_secret() ? goal_bits(site.secret_episodes(phase), site.graphs()) : 0};
    const auto is_apart = [&phase](const Group& group) {
      return std::ranges::none_of(
          group.phases, [&phase](const Phase* other) { return share_goals(&phase, other); });
    };
    // The phase may join groups that were apart so far.
    const auto touched = std::stable_partition(groups_.begin(), groups_.end(), is_apart);
    for (auto group = touched; group != groups_.end(); ++group) {
      joined.phases.insert(joined.phases.end(), group->phases.begin(), group->phases.end());
      joined.goal_bits = std::max(joined.goal_bits, group->goal_bits);
    }
    groups_.erase(touched, groups_.end());
    std::ranges::sort(joined.phases);  // they lie in one vector
    groups_.push_back(std::move(joined));
  }
}

const SharedGoals::Group& SharedGoals::of(const Phase& phase) const {
  const auto found = std::ranges::find_if(groups_, [&phase](const Group& group) {
    return std::ranges::find(group.phases, &phase) != group.phases.end();
  });
  EN_CHECK(found != groups_.end());
  return *found;
}

}  // namespace enfilade::service::evaluation
