/// \file  Episodes for language models and assistants: a split of any benchmark, and its pictures.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "enfilade/arena/pictures.h"
#include "enfilade/arena/words.h"
#include "enfilade/arena/world.h"
#include "enfilade/dataset/dataset.h"

namespace enfilade::apps {

/// A split for sessions.
struct OpenedWorld {
  std::unique_ptr<arena::World> world;
  arena::Sights sights;
  std::string title;  ///< of the benchmark
};
/// Makes words of a world's pictures.
using WordsMaker = std::function<arena::WordsSource(const arena::Sights&)>;
/// \param task as in --task \param words empty: none
/// \throws as task_of(), episodes_of(), arena::FreeWorld::open()
OpenedWorld open_world(const std::shared_ptr<const dataset::Dataset>& data, const std::string& task,
                       const std::string& split, const WordsMaker& words = {});

}  // namespace enfilade::apps
