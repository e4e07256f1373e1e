/// \file  Writes the annotations of all benchmarks for a set of homes, each in its own form.
/// Internal.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "enfilade/homes/benchmarks/guides.h"
#include "enfilade/homes/built_home.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/homes/instructions/speaker.h"
#include "enfilade/homes/sets/written_files.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::homes::benchmarks {

/// Collects the texts of each home, then writes them by split.
class Benchmarks {
 public:
  /// \throws ArgumentError for a name in options.tasks that home_tasks() has not
  explicit Benchmarks(const HomePathOptions& options);

  /// Adds a home's paths, which get their three instructions of Room-to-Room.
  void add_home(const BuiltHome& built, const graph::NavGraph& graph,
                std::span<tasks::PathAnnotation> paths);

  /// Writes `<task>/` of all tasks except R2R itself, and hidden goals below `hidden/<task>/`.
  /// \param splits  of Room-to-Room, as tasks::split_by_building() gives them, with instructions
  /// \throws FileError
  void write(sets::WrittenFiles& files, const std::map<std::string, tasks::Annotations>& splits,
             const graph::GraphSet& graphs) const;

  /// How many instructions of Room-to-Room add_home() has written.
  std::size_t instructions() const noexcept { return instructions_; }

 private:
  /// The texts of one path of Room-to-Room.
  struct Said {
    std::vector<std::vector<instructions::SpokenPart>> parts;  // of each instruction
    GuidedPath guided;
    std::vector<tasks::PathAnnotation> requests, dialogue, descriptions, again;
  };
  class Writer;

  bool wants(std::string_view task) const;

  HomePathOptions options_;
  std::map<std::int64_t, Said> said_;  // by path_id
  tasks::ObjectBoxes boxes_;
  std::size_t instructions_ = 0;
};

}  // namespace enfilade::homes::benchmarks
