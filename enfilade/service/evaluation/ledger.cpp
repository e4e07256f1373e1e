#include "enfilade/service/evaluation/ledger.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>
#include <string_view>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "enfilade/core/enum_names.h"
#include "enfilade/core/errors.h"
#include "enfilade/service/detail/texts.h"
#include "enfilade/service/evaluation/leakage.h"
#include "enfilade/service/store/database.h"

namespace enfilade::service::evaluation {
namespace {

constexpr std::size_t kKeyBytes = 8;  // of a goal, the lowest first

std::string bytes_of(const GoalKeys& keys) {
  std::string bytes;
  bytes.reserve(kKeyBytes * keys.size());
  for (std::uint64_t key : keys) {
    for (std::size_t k = 0; k < kKeyBytes; ++k, key >>= 8U) {
      bytes.push_back(static_cast<char>(key & 0xFFU));
    }
  }
  return bytes;
}

GoalKeys keys_of(std::string_view bytes) {
  GoalKeys keys(bytes.size() / kKeyBytes);
  for (std::size_t k = keys.size() * kKeyBytes; k-- > 0;) {
    std::uint64_t& key = keys[k / kKeyBytes];
    key = (key << 8U) | static_cast<unsigned char>(bytes[k]);
  }
  return keys;
}

/// All that decides what a phase's scores tell. Of hidden ones nothing does.
std::string rule_text(const Phase& phase) {
  return fmt::format("{} {} {} {} {} {}", phase.benchmark->name, phase.split, phase.scorer->name,
                     phase.primary, phase.step, enum_name(phase.scores));
}

std::int64_t levels_of(const Phase& phase) {
  return grid_of(phase, phase.primary_measure()).levels();
}

/// Sets that are joined; each is named by one of its members.
class Sets {
 public:
  explicit Sets(std::size_t size) : above_(size) { std::iota(above_.begin(), above_.end(), 0U); }
  std::size_t find(std::size_t k) {
    while (above_[k] != k) k = above_[k] = above_[above_[k]];
    return k;
  }
  void join(std::size_t one, std::size_t other) { above_[find(one)] = find(other); }

 private:
  std::vector<std::size_t> above_;
};

struct UsedRule {
  std::string phase;
  std::int64_t levels = 0;
  double means = 0;
  bool shown = false;

  auto columns() { return std::tie(phase, levels, means, shown); }
};

std::string whole_bits(double bits) {
  return std::isfinite(bits) ? fmt::format("{:.0f}", std::ceil(bits)) : "any number of";
}

/// Of a phase whose limits give all of its goals away.
std::string leak_text(const std::string& phase, const Leakage& leakage) {
  const std::string bits = whole_bits(leakage.most), goals = whole_bits(leakage.goals);
  if (leakage.phases.size() == 1) {
    return fmt::format("phase {}: its limits give away up to {} bits, and its goals have {}", phase,
                       bits, goals);
  }
  return fmt::format(
      "phases {} share goals: their limits give away up to {} bits, and the goals of {} have {}",
      fmt::join(leakage.phases, ", "), bits, phase, goals);
}

}  // namespace

Ledger::Ledger(const Site& site, store::Database& db, Leaks leaks) : site_(site), db_(db) {
  for (const Phase& phase : site.phases()) {
    if (!phase.goals_secret()) continue;
    goal_bits_.emplace(phase.name, goal_bits(site.secret_episodes(phase).split, site.graphs()));
  }
  // A server that is refused leaves no rules behind: their phases would stay joined for ever.
  db.transact([&] {
    for (const Phase& phase : site.phases()) {
      if (phase.goals_secret()) add_rule(phase);
    }
    join();
    if (leaks == Leaks::kRefused) check();
  });
}

void Ledger::check() const {
  std::vector<Diagnostic> faults;
  const std::map<std::string, Leakage> leakages = leakage();
  for (const Phase& phase : site_.phases()) {
    const auto found = leakages.find(phase.name);
    if (found == leakages.end() || !found->second.gives_all()) continue;
    faults.push_back({Severity::kError, phase.annotations.string(), "$", "goals-given-away",
                      leak_text(phase.name, found->second) +
                          "; hide the scores (\"scores\": \"hidden\"), or write a larger \"step\", "
                          "fewer \"teams\" or a smaller \"per_team\"; --accept-leak serves it as "
                          "it is"});
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
}

void Ledger::add_rule(const Phase& phase) {
  const std::string keys = bytes_of(site_.secret_episodes(phase).keys);
  const std::string rule = rule_text(phase);
  const std::string digest = detail::sha256(keys);
  const bool hidden = phase.scores == Scores::kHidden;
  const bool first =
      db_.find_number("SELECT count(*) FROM phase_rule WHERE phase = ?", phase.name) == 0;
  std::int64_t id =
      db_.find_number("SELECT id FROM phase_rule WHERE phase = ? AND rule = ? AND digest = ?",
                      phase.name, rule, digest);
  if (id == 0) {
    id = db_.insert(
        "INSERT INTO phase_rule (phase, rule, digest, goals, levels, means_bits) "
        "VALUES (?, ?, ?, ?, ?, ?)",
        phase.name, rule, digest, store::Blob{keys},
        phase.scores == Scores::kLadder ? levels_of(phase) : 0, hidden ? 0.0 : means_bits(phase));
  }
  if (first) adopt_rows(phase, id);
  adopt_scores(phase, id);
  rules_.emplace(phase.name, id);
}

void Ledger::adopt_rows(const Phase& phase, std::int64_t rule) {
  const auto at = db_.find<std::int64_t>("SELECT at FROM phase_end WHERE phase = ?", phase.name);
  if (!at) return;
  db_.run("UPDATE phase_rule SET rows_shown = ?, means_bits = ? WHERE id = ?", *at,
          means_bits(phase), rule);
}

void Ledger::adopt_scores(const Phase& phase, std::int64_t rule) {
  const std::string old = "submission WHERE phase = ? AND rule IS NULL AND score IS NOT NULL";
  if (db_.find_number("SELECT count(*) FROM " + old, phase.name) == 0) return;
  if (db_.find_number("SELECT count(*) FROM " + old + " AND shown IS NOT NULL", phase.name) != 0) {
    db_.run("UPDATE phase_rule SET levels = ? WHERE id = ?", levels_of(phase), rule);
  }
  db_.run("UPDATE submission SET rule = ? WHERE id IN (SELECT id FROM " + old + ")", rule,
          phase.name);
}

void Ledger::join() {
  const auto rows = db_.select<std::tuple<std::string, std::string>>(
      "SELECT phase, goals FROM phase_rule ORDER BY id");
  std::vector<std::string> names;  // those of now first
  std::map<std::string, std::size_t> places;
  const auto place_of = [&](const std::string& name) {
    const auto [found, is_new] = places.try_emplace(name, names.size());
    if (is_new) names.push_back(name);
    return found->second;
  };
  for (const Phase& phase : site_.phases()) {
    if (phase.goals_secret()) place_of(phase.name);
  }
  for (const auto& [name, goals] : rows) place_of(name);
  Sets sets(names.size());
  std::unordered_map<std::uint64_t, std::size_t> by_key;
  for (const auto& [name, goals] : rows) {
    const std::size_t place = place_of(name);
    for (const std::uint64_t key : keys_of(goals)) {
      sets.join(place, by_key.try_emplace(key, place).first->second);
    }
  }
  std::map<std::pair<std::string, tasks::Task>, std::size_t> by_split;
  for (const Phase& phase : site_.phases()) {
    if (!phase.goals_secret()) continue;
    const std::size_t place = place_of(phase.name);
    const auto first = by_split.try_emplace({phase.split, phase.benchmark->paths}, place).first;
    sets.join(place, first->second);
  }
  std::map<std::size_t, std::size_t> numbers;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto [number, is_new] = numbers.try_emplace(sets.find(k), groups_.size());
    if (is_new) groups_.emplace_back();
    groups_[number->second].push_back(names[k]);
    group_of_[names[k]] = number->second;
  }
}

double Ledger::used_by(std::int64_t id) const {
  const auto rule = db_.get<UsedRule>(
      "SELECT phase, levels, means_bits, rows_shown IS NOT NULL FROM phase_rule WHERE id = ?", id);
  const auto counts = [&](const std::string& condition, const auto& value) {
    return db_.select<std::int64_t>("SELECT count(*) FROM submission WHERE " + condition +
                                        " AND score IS NOT NULL GROUP BY team",
                                    value);
  };
  double bits = 0;
  if (rule.levels > 0) {
    for (const std::int64_t count : counts("rule = ?", id)) {
      bits += ladder_bits(count, rule.levels);
    }
  }
  // A row is the best of all files, whatever rules there were when they were scored.
  if (rule.shown) {
    for (const std::int64_t count : counts("phase = ?", rule.phase)) {
      bits += row_bits(rule.means, count);
    }
  }
  return bits;
}

double Ledger::limit_bits(const Phase& phase) const {
  const double by_limits = most_bits(phase);
  if (phase.scores == Scores::kHidden || !phase.per_team) return by_limits;
  // The limits may have been larger when these were taken, and their scores are yet to be shown.
  const auto counts = db_.select<std::int64_t>(
      "SELECT count(*) FROM submission WHERE phase = ? GROUP BY team", phase.name);
  const auto others = std::max<std::ptrdiff_t>(0, phase.teams - std::ssize(counts));
  double bits = static_cast<double>(others) * team_bits(phase, *phase.per_team, true);
  for (const std::int64_t count : counts) {
    bits += team_bits(phase, std::max<std::int64_t>(count, *phase.per_team), true);
  }
  return bits;
}

Leakage Ledger::leakage_of(const std::vector<std::string>& group) const {
  Leakage all;
  for (const std::string& name : group) {
    const auto now = rules_.find(name);
    const std::int64_t current = now == rules_.end() ? 0 : now->second;
    double of_limits = current == 0 ? 0 : limit_bits(*site_.find_phase(name));
    const double before = all.used;
    for (const std::int64_t id :
         db_.select<std::int64_t>("SELECT id FROM phase_rule WHERE phase = ?", name)) {
      const double used = used_by(id);
      all.used += used;
      if (id == current) {
        of_limits = std::max(of_limits, used);  // a hidden phase may have shown scores once
      } else {
        all.most += used;
      }
    }
    all.most += of_limits;
    if (current != 0 || all.used > before) all.phases.push_back(name);
  }
  return all;
}

std::map<std::string, Leakage> Ledger::leakage() const {
  std::vector<std::optional<Leakage>> of_groups(groups_.size());
  std::map<std::string, Leakage> found;
  for (const auto& [name, bits] : goal_bits_) {
    const std::size_t group = group_of_.at(name);
    if (!of_groups[group]) of_groups[group] = leakage_of(groups_[group]);
    Leakage& one = found.emplace(name, *of_groups[group]).first->second;
    one.goals = bits;
  }
  return found;
}

void Ledger::show_rows(const Phase& phase) const {
  db_.run("UPDATE phase_rule SET rows_shown = ? WHERE id = ? AND rows_shown IS NULL", db_.now(),
          rule_of(phase));
}

std::vector<std::string> Ledger::warnings() const {
  std::vector<std::string> found;
  const std::map<std::string, Leakage> leakages = leakage();
  std::set<std::size_t> told;
  for (const Phase& phase : site_.phases()) {
    if (!phase.goals_secret()) continue;
    const Leakage& all = leakages.at(phase.name);
    if (!all.gives_all() || !told.insert(group_of_.at(phase.name)).second) continue;
    found.push_back(leak_text(phase.name, all));
  }
  for (const auto& name : db_.select<std::string>(
           "SELECT phase FROM phase_end WHERE phase NOT IN (SELECT phase FROM phase_rule) "
           "ORDER BY phase")) {
    found.push_back(
        fmt::format("the database has rows of phase {}, which an older Enfilade showed; "
                    "to count them, serve it once more with its name and annotations",
                    name));
  }
  return found;
}

}  // namespace enfilade::service::evaluation
