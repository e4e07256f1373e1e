/// \file  What language models and assistants walk: a split of any benchmark, and its pictures.
#pragma once
#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "enfilade/arena/pictures.h"
#include "enfilade/arena/world.h"
#include "enfilade/dataset/dataset.h"

namespace enfilade::apps {

/// A split as sessions walk it.
struct OpenedWorld {
  std::unique_ptr<arena::World> world;
  arena::Sights sights;
  std::string title;  ///< of the benchmark
};
/// \param task as --task has it \param words as --words has it
/// \throws as task_of(), episodes_of(), arena::FreeWorld::open()
OpenedWorld open_world(const std::shared_ptr<const dataset::Dataset>& data, const std::string& task,
                       const std::string& split, const std::string& words);
/// Adds `--words none|labels`.
void add_words_option(CLI::App& verb, std::string& words);

}  // namespace enfilade::apps
