/// \file  Recorded rollouts, which the network learns from: observations, actions and advice.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "enfilade/features/tensor_file.h"
#include "enfilade/neural/continuous/sight.h"

namespace enfilade::neural::continuous {

/// One walk of n steps.
struct RecordedEpisode {
  std::size_t episode = 0;             ///< of those trained on
  Seen seen;                           ///< of n steps; empty without vision
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

}  // namespace enfilade::neural::continuous
