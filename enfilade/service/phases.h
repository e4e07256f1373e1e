/// \file  What submissions are scored on.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade::service {

/// Who is shown a phase's scores. Whether its goals are secret is another question.
enum class Scores {
  kPublic,  ///< everybody: there is a leaderboard
  kHidden,  ///< organisers only; a team is told that its file was scored
};

/// A split to be scored on, and by which rules.
struct Phase {
  std::string name;   ///< [a-z0-9_-], 1 to 40 of them: a part of URLs
  std::string title;  ///< for people
  std::string split;  ///< "val_unseen"; its instructions are served without their goals if secret
  /// R2R annotations with goals, kept out of the data set so that nobody can download them. Empty:
  /// those of the data set, which are no secret.
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
