/// \file  How the panoramic agent chose, step by step, for files of decisions.
#pragma once
#include <cstddef>
#include <span>

#include "enfilade/models/decision_recorder.h"
#include "enfilade/neural/panoramic/panoramic_split.h"

namespace enfilade::neural::panoramic {

/// Records the steps of walk_episodes(). One thread at a time.
class PanoramicRecording {
 public:
  /// For all episodes of a split.
  explicit PanoramicRecording(const PanoramicSplit& split);

  /// An observer of a rollout of these episodes, which have to stay as long as it is used.
  BatchObserver observer(std::span<const std::size_t> episodes);
  const models::DecisionRecorder& recorder() const noexcept { return recorder_; }

 private:
  void add(const PanoramicStep& step, std::size_t row, std::size_t episode, std::size_t words);

  models::DecisionRecorder recorder_;
};

}  // namespace enfilade::neural::panoramic
