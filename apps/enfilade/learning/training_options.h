/// \file  The options of a training, for train and study.
#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "enfilade/models/train_options.h"

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
  using Rows = std::vector<const models::TrainOption*>;  // of one flag
  void add_size(CLI::App& verb);
  void add(CLI::App& verb, const Rows& rows);
  models::AgentKind kind() const;

  std::string agent_, task_, recipe_, stage_;
  struct Change {
    CLI::Option* option;
    std::function<bool(models::AgentKind)> of;
    std::function<void(models::TrainConfig&)> apply;
  };
  std::vector<Change> changes_;
};

}  // namespace enfilade::apps
