/// \file  Phases of an evaluation: the splits that submissions are scored on.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade::service {

/// Who may see a phase's scores. Secret goals are another setting: Phase::annotations.
enum class Scores {
  kPublic,  ///< everybody: there is a leaderboard
  kHidden,  ///< organisers only; a team is told that its file was scored
};

/// A split to score on, and its rules.
struct Phase {
  std::string name;   ///< 1 to 40 of a-z, 0-9, - and _: a part of URLs
  std::string title;  ///< for people
  std::string split;  ///< "val_unseen"; its instructions are served without their goals if secret
  /// R2R annotations with goals, kept outside the data set, which everybody can download. Empty:
  /// the data set's own annotations, with open goals.
  std::filesystem::path annotations;
  Scores scores = Scores::kPublic;
  int per_day = 10;  ///< submissions of a team in 24 hours, 1 to 1000

  bool goals_secret() const noexcept { return !annotations.empty(); }
};

/// Reads {"phases": [{"name", "title", "split", "annotations", "scores": "public" | "hidden",
/// "per_day"}]}; name and split have to be there. A relative path of annotations begins at the
/// file's folder.
/// \throws FileError; InvalidInput listing every fault with its JSON path
std::vector<Phase> load_phases(const std::filesystem::path& file);
std::vector<Phase> parse_phases(std::string_view json, const std::string& file);

}  // namespace enfilade::service
