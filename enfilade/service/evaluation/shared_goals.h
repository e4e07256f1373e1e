/// \file  Phases that score on the same secret goals: what one gives away, it gives away of all.
#pragma once
#include <vector>

#include "enfilade/service/site.h"

namespace enfilade::service::evaluation {

/// Which phases share their goals. Immutable: any thread.
class SharedGoals {
 public:
  struct Group {
    std::vector<const Phase*> phases;  ///< in the order of Site::phases()
    double goal_bits = 0;              ///< leakage.h
  };

  /// Secret phases share their goals if they name one annotations file, by any path, or one split
  /// of benchmarks that share their paths.
  /// \pre site outlives *this
  explicit SharedGoals(const Site& site);

  /// The group that a phase is in; of open goals it is the phase alone. \pre phase is one of the
  /// site's
  const Group& of(const Phase& phase) const;

 private:
  std::vector<Group> groups_;
};

}  // namespace enfilade::service::evaluation
