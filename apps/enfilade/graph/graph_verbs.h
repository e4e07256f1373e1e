/// \file  The verbs of `enfilade graph` that have a file of their own.
#pragma once
#include <CLI/CLI.hpp>

namespace enfilade::apps {

void add_graph_build(CLI::App& graph, int& status);    ///< a mesh's viewpoints and edges
void add_graph_compare(CLI::App& graph, int& status);  ///< two graphs of one building

}  // namespace enfilade::apps
