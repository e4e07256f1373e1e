/// \file  Which episodes answer an entry of SOON's files. Internal, as it includes simdjson.
#pragma once
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/detail/json.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks::formats {

/// The viewpoint where an answer of the released form begins: the first text in its `path`. No
/// value if it is missing; reading the answer reports that.
std::optional<std::string_view> soon_start(json::Element answer);

/// Episodes by entry, instruction and start. The episodes have to outlive it.
class SoonEntries {
 public:
  /// From SOON's episodes in the released form; empty for all others.
  explicit SoonEntries(const EpisodeSet& episodes);

  std::size_t size() const noexcept { return entries_.size(); }  ///< named entries
  /// Whether `id` is an entry's, or that with "_" and the number of an instruction behind it.
  bool knows(std::string_view id) const { return !instructions_of(id).empty(); }

  /// The result of find().
  struct Found {
    std::optional<std::size_t> episode;  ///< index of the episode
    bool any = false;                    ///< whether a path of the entry begins there
  };
  /// The first episode of entry `id` that begins at `start` and has no answer yet: instruction by
  /// instruction, alternatives in their order.
  Found find(std::string_view id, std::string_view start,
             const std::function<bool(std::size_t)>& answered) const;

 private:
  using Instruction = std::vector<std::size_t>;  // episodes, one an alternative
  using Entry = std::map<std::size_t, Instruction>;
  std::vector<const Instruction*> instructions_of(std::string_view id) const;

  const EpisodeSet& episodes_;
  std::map<std::string, Entry, std::less<>> entries_;
};

}  // namespace enfilade::tasks::formats
