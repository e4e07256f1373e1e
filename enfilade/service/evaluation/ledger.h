/// \file  What was given away of secret goals: an account for the goals, not for the names of
/// phases. So it goes on when a phase is renamed, changed, ended or removed.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "enfilade/service/site.h"

namespace enfilade::service::store {
class Database;
}

namespace enfilade::service::evaluation {

/// How much is given away of a phase's goals: see leakage.h.
struct Leakage {
  double most = 0;   ///< bits that the limits of all phases with such goals allow, and former ones
                     ///< have used; or used bits if more
  double used = 0;   ///< bits so far, by all of them
  double goals = 0;  ///< bits of the phase's own goals
  std::vector<std::string> phases;  ///< those of now, then former ones with used bits

  bool gives_all() const noexcept { return most > goals; }
};

/// What happens to a server whose limits allow more bits than goals have.
enum class Leaks { kRefused, kAccepted };

/// The rules by which secret phases show scores, with the keys of their goals, as the database has
/// them of all servers so far. All functions may be called from any thread.
///
/// Phases belong together if they share a key (goal_keys.h), also by way of a third one. So do
/// phases with one split and the same paths (share_paths()).
class Ledger {
 public:
  /// Adds the rules of the site's phases. Scores that older programs stored count as of the phase's
  /// rule now. Those that were shown count even if it hides scores. \pre both outlive *this
  /// \throws InvalidInput if Leakage::gives_all() of a phase, unless that is accepted; the database
  /// stays as it was
  Ledger(const Site& site, store::Database& db, Leaks leaks);

  /// The id of the rule by which a phase shows scores. \pre its goals are secret
  std::int64_t rule_of(const Phase& phase) const { return rules_.at(phase.name); }
  /// By the names of all phases with secret goals.
  std::map<std::string, Leakage> leakage() const;
  /// From now on its rows are shown. \pre in a transaction; the goals are secret
  void show_rows(const Phase& phase) const;
  /// For the organiser: a sentence for each group of phases whose limits give their goals away, and
  /// for scores whose goals are not known.
  std::vector<std::string> warnings() const;

 private:
  void add_rule(const Phase& phase);
  /// What an older program showed counts, even if the phase hides it by now.
  void adopt_rows(const Phase& phase, std::int64_t rule);
  void adopt_scores(const Phase& phase, std::int64_t rule);
  void join();
  void check() const;
  double used_by(std::int64_t rule) const;
  /// most_bits() with the submissions that there are, which may be more than the limits allow now.
  double limit_bits(const Phase& phase) const;
  /// Without the bits of goals.
  Leakage leakage_of(const std::vector<std::string>& group) const;

  const Site& site_;
  store::Database& db_;
  std::map<std::string, std::int64_t> rules_;    // of secret phases, by their names
  std::map<std::string, double> goal_bits_;      // the same
  std::map<std::string, std::size_t> group_of_;  // of all names
  std::vector<std::vector<std::string>> groups_;
};

}  // namespace enfilade::service::evaluation
