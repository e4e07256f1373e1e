/// \file  How DUET chose, step by step, for files of decisions.
#pragma once
#include <cstddef>
#include <map>
#include <span>
#include <vector>

#include "enfilade/models/decision_recorder.h"
#include "enfilade/neural/duet/duet_split.h"

namespace enfilade::neural::duet {

/// Records the steps of walk_episodes(). One thread at a time.
class DuetRecording {
 public:
  /// For all episodes of a split.
  explicit DuetRecording(const DuetSplit& split);

  /// An observer of a rollout of these episodes, which have to stay as long as it is used.
  StepWatcher observer(std::span<const std::size_t> episodes);
  const models::DecisionRecorder& recorder() const noexcept { return recorder_; }

 private:
  void add(const StepOfAll& step, std::size_t row, std::size_t episode);

  models::DecisionRecorder recorder_;
  std::map<std::size_t, std::map<ViewpointIndex, float>> stops_;  // by episode
};

}  // namespace enfilade::neural::duet
