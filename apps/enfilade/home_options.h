/// \file  Options that `enfilade homes` and `enfilade dataset` share.
#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace enfilade::apps {

/// Adds `--tasks`. \param tasks  homes::HomePathOptions::tasks; as it is where the option is not
/// given
void add_tasks_option(CLI::App& verb, std::vector<std::string>& tasks);

}  // namespace enfilade::apps
