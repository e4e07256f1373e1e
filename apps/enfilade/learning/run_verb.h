/// \file  Other verbs of this program as steps of a longer work.
#pragma once
#include <string>
#include <vector>

namespace enfilade::apps {

/// Prints the command and runs it in a process of its own (libtorch is another program's). Prints
/// the seconds that it took.
/// \returns its exit code
/// \throws FileError if it cannot be started
int run_verb(const std::vector<std::string>& words);

}  // namespace enfilade::apps
