/// \file  `enfilade import-weights`, which needs libtorch.
#pragma once
#include <CLI/CLI.hpp>

namespace enfilade::apps {

inline constexpr const char* kImportWeightsHelp =
    "Make a model directory of released weights: DUET, ScaleVLN, EnvDrop";

/// As the verbs of verbs.h. In `enfilade` it starts `enfilade-learn`.
void add_import_weights(CLI::App& app, int& status);

}  // namespace enfilade::apps
