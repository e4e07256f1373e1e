/// \file  Recorded trajectories of a training: their files, their order, and batches of them.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "enfilade/features/tensor_file.h"
#include "enfilade/models/network_config.h"
#include "enfilade/neural/continuous/network.h"

namespace enfilade::neural::continuous {

/// Observations of n steps, as files of rollouts store them.
struct SightRows {
  std::vector<std::uint16_t> pictures;  ///< (n, features) halves
  std::vector<std::uint8_t> depth;      ///< (n, kDepthSize) 255: 10 m and more, or no surface
};

/// One walk of n steps.
struct RecordedEpisode {
  std::size_t episode = 0;             ///< of those trained on
  SightRows seen;                      ///< of n steps; empty without vision
  std::vector<std::uint8_t> previous;  ///< (n) kNoAction or 1 + the choice before
  std::vector<std::uint8_t> teacher;   ///< (n) the teacher's choices
};

/// What a recorded walk is to one who reads it. Valid as long as what it is of.
struct EpisodeView {
  std::size_t episode = 0;
  std::span<const std::uint16_t> pictures;          ///< (n, features), or empty
  std::span<const std::uint8_t> depth;              ///< (n, kDepthSize), or empty
  std::span<const std::uint8_t> previous, teacher;  ///< (n)

  std::size_t steps() const noexcept { return teacher.size(); }
};
EpisodeView view_of(const RecordedEpisode& walk);

/// Walks of a file, which is mapped into memory. Immutable: any thread.
class EpisodeFile {
 public:
  /// \param features numbers per picture; 0: no vision \throws FileError; InvalidInput
  /// for another file, or one of other sizes
  EpisodeFile(const std::filesystem::path& file, std::size_t features);

  std::size_t size() const noexcept { return episodes_.size(); }
  EpisodeView walk(std::size_t i) const;  ///< \pre i < size()
  /// The hash of the weights of the agent that walked.
  const std::string& weights() const { return file_.metadata().at("weights"); }

 private:
  features::TensorFile file_;
  std::size_t features_;
  std::span<const std::uint16_t> pictures_;
  std::span<const std::uint8_t> depth_, previous_, teacher_;
  std::span<const std::int64_t> episodes_;
  std::vector<std::size_t> first_;  // step of each walk, and the number of all steps
};

/// Writes such a file. Atomic. \param weights a hash \throws FileError
void write_episodes(const std::filesystem::path& file, std::span<const RecordedEpisode> walks,
                    const std::string& weights);

/// Position of an update in a training.
struct UpdatePlace {
  std::size_t sets = 1;   ///< that there are then
  std::size_t epoch = 0;  ///< over these
  std::size_t batch = 0;  ///< of this pass
  /// Whether it is the first after the last set was gathered.
  bool first() const noexcept { return epoch == 0 && batch == 0; }
};
/// \pre update < models::updates_of(config, batch)
UpdatePlace place_of(const models::Seq2SeqCeConfig& config, std::size_t batch,
                     std::uint64_t update);

/// The batches of one pass over trajectories, each once; the last batch may be smaller.
/// Trajectories of a batch are about as long as each other, and longer ones come first. Of 16
/// batches' trajectories, which are drawn, those of like length go together.
/// \param lengths steps by trajectory
std::vector<std::vector<std::size_t>> pass_over(std::span<const std::size_t> lengths,
                                                std::size_t batch, std::uint64_t seed,
                                                std::uint64_t pass);

/// Walks side by side, and what the teacher said at each of their steps.
struct TrajectoryBatch {
  StepRows steps;
  at::Tensor teacher;                 ///< (rows) int64
  std::vector<std::size_t> episodes;  ///< per trajectory
};
/// \pre one walk at least, longer ones first; each has a step
TrajectoryBatch side_by_side(std::span<const EpisodeView> walks, const Sizes& sizes);

}  // namespace enfilade::neural::continuous
