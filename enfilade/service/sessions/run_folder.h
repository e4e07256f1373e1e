/// \file  A run as the site may show it: its description, its split, the episodes that everybody
/// may see.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/service/detail/once_cache.h"
#include "enfilade/service/sessions/transcripts.h"
#include "enfilade/service/site.h"

namespace enfilade::service::sessions {

/// One path of a split with the number of one of its instructions.
struct EpisodePlace {
  const PublicSplit* split = nullptr;
  const tasks::PathAnnotation* path = nullptr;
  std::size_t number = 0;

  const std::string& text() const { return path->instructions[number]; }
};

/// The episodes of a split by their instruction ids, also fourth ones; of repeated ids the first.
using SplitIndex = std::map<std::string, EpisodePlace, std::less<>>;
/// The place of an id; null if there is none, or no index.
const EpisodePlace* find_place(const SplitIndex* index, std::string_view id);

/// The indices of a site's splits, made when they are first needed. Any thread.
class SplitIndices {
 public:
  SplitIndices();
  std::shared_ptr<const SplitIndex> of(const PublicSplit& split);

 private:
  detail::OnceCache<const PublicSplit*, std::shared_ptr<const SplitIndex>> made_;
};

/// A folder of a run, and what is known of it. The site outlives it.
struct Run {
  std::string name;
  std::filesystem::path folder;
  std::optional<std::string> task = {}, split = {}, model = {}, prompt = {};
  std::uint32_t picture_size = 512;  ///< pixels
  std::string problem = {};
  std::vector<NamedPath> transcripts = {};       ///< those that everybody may see
  const PublicSplit* served = nullptr;           ///< its split at this site; null: none
  std::shared_ptr<const SplitIndex> index = {};  ///< of `served`; null without it

  /// {"run", "task", "split", "model", "prompt", "outcomes", "episodes", "problem"?}
  nlohmann::ordered_json to_json() const;
  bool is_continuous() const;
  bool goals_hidden() const { return served != nullptr && served->goals_hidden; }
  /// Whether success may be shown: the site has the split, with its goals.
  bool has_outcomes() const { return served != nullptr && !served->goals_hidden; }
  const EpisodePlace* find(std::string_view id) const { return find_place(index.get(), id); }
  /// Whether an episode's text may be shown. Where goals are hidden it must be that of the site's
  /// split, as texts may tell goals.
  bool shows_text(std::string_view id, std::string_view instruction) const;
  /// The transcript of an episode. \throws Refusal kNotFound
  const NamedPath& transcript_of(std::string_view episode) const;
};

/// Reads what a folder says of its run. Ids and texts may tell goals: REVERIE's name objects, R4R's
/// texts are of two paths. Only what the site shows of a split with hidden goals is shown. If there
/// are secret goals, nothing is shown of a split that the site does not have.
Run open_run(NamedPath found, const Site& site, SplitIndices& indices);

}  // namespace enfilade::service::sessions
