/// \file  The options of a training, for train and study.
#pragma once
#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/models/train_config.h"

namespace enfilade::apps {

/// Options that change a recipe. Others are as in models::recipe().
class TrainingOptions {
 public:
  /// Adds --agent, --task, --recipe, --stage and all that changes it. *this outlives the verb.
  /// \param recipe the default: "published" or "small"
  void add_to(CLI::App& verb, const std::string& recipe = "published");
  /// The verb has no such option after all.
  void leave_out(CLI::App& verb, const std::string& name);
  /// The recipe of the agent with the changes. \throws UsageError for an option that another kind
  /// of agent has; ArgumentError as validate()
  models::TrainConfig config() const;
  /// "r2r-ce" for a continuous agent; else "r2r".
  const std::string& task() const noexcept { return task_; }
  /// The words on a command line that give the same options again.
  std::vector<std::string> words() const;

 private:
  using Kinds = std::vector<models::AgentKind>;
  template <class T>
  CLI::Option* change(CLI::App& verb, const std::string& name, const std::string& help,
                      const Kinds& kinds,
                      const std::function<void(models::TrainConfig&, const T&)>& apply);
  void whole(CLI::App& verb, const std::string& name, const std::string& help, const Kinds& kinds,
             const std::function<std::size_t&(models::TrainConfig&)>& field,
             std::uint64_t least = 1);
  void real(CLI::App& verb, const std::string& name, const std::string& help, const Kinds& kinds,
            const std::function<double&(models::TrainConfig&)>& field);
  void name(CLI::App& verb, const std::string& name, const std::string& help, const Kinds& kinds,
            const std::vector<std::string>& allowed,
            const std::function<void(models::TrainConfig&, const std::string&)>& apply);
  void add_sizes(CLI::App& verb);
  void add_updates(CLI::App& verb);

  models::AgentKind kind() const;
  void add_seq2seq_ce(CLI::App& verb);

  std::string agent_, task_, recipe_, stage_;
  struct Change {
    CLI::Option* option;
    Kinds kinds;  // empty: of all
    std::function<void(models::TrainConfig&)> apply;
  };
  std::vector<Change> changes_;
};

}  // namespace enfilade::apps
