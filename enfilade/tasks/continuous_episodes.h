/// \file  Episodes in continuous space, as VLN-CE's files have them. An episode has a start pose in
/// a building, an instruction, a goal that is a point, and the points of a path to it. Files are in
/// Habitat's frame; everything here is in our world frame (metres, z up).
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "enfilade/geometry/angle.h"
#include "enfilade/geometry/vec.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks {

/// An id as its file has it: R2R-CE's are whole numbers, RxR-CE's are texts.
using FileId = std::variant<std::int64_t, std::string>;
/// Its text: "302" for both 302 and "302", which Habitat takes for one id.
std::string text_of(const FileId& id);

/// Fields that the model has no place for, with their values as JSON without blanks, in the order
/// of the file: they are written back.
using OtherFields = std::vector<std::pair<std::string, std::string>>;

/// The orientation of a body at its start, as the file has it. It is a quaternion (x, y, z, w) of
/// Habitat's frame about its vertical axis. A heading would lose its last bits and its sign.
struct StartRotation {
  double x = 0, y = 0, z = 0, w = 1;

  /// Our heading in [0, 2 pi). \pre y and w are not both 0
  Radians heading() const;
  /// The way back.
  static StartRotation of(Radians heading);
  friend bool operator==(const StartRotation&, const StartRotation&) = default;
};

/// Goal of an episode.
struct ContinuousGoal {
  Vec3d position;
  std::optional<double> radius;  ///< metres, 0 or more; 3 in all released files
  OtherFields others = {};
  friend bool operator==(const ContinuousGoal&, const ContinuousGoal&) = default;
};

/// Whose walk an episode of RxR-CE is.
enum class AnnotationRole : std::uint8_t { kGuide, kFollower };

/// `info` of an episode.
struct EpisodeInfo {
  std::optional<double> geodesic_distance;  ///< from the start to the goal, metres, 0 or more
  std::optional<AnnotationRole> role;
  OtherFields others = {};
  friend bool operator==(const EpisodeInfo&, const EpisodeInfo&) = default;
};

/// What an episode asks for in words. R2R-CE has the text and its tokens, RxR-CE the rest.
struct ContinuousInstruction {
  std::string text;
  /// Ids of the file's vocabulary, padded to one length.
  std::optional<std::vector<std::int32_t>> tokens = {};
  std::optional<FileId> id = {};
  std::optional<std::string> language = {};  ///< BCP 47: "en-IN"
  std::optional<FileId> annotator = {};
  std::optional<double> edit_distance = {};
  std::optional<std::vector<TimedWord>> words = {};
  OtherFields others = {};
  friend bool operator==(const ContinuousInstruction&, const ContinuousInstruction&) = default;
};

/// The scan of a scene's path: its file's name without folders and extensions. If the file's folder
/// is named after it, as HM3D's are, its folder's name: "00800-TEEsavR23oF" of
/// "hm3d/val/00800-TEEsavR23oF/TEEsavR23oF.basis.glb". A part of `scene`; empty for a folder.
std::string_view scan_of_scene(std::string_view scene) noexcept;
/// Its inverse: "mp3d/zsNo4HB9uLZ/zsNo4HB9uLZ.glb" for the folder "mp3d". HM3D's ids give
/// "hm3d/val/00800-TEEsavR23oF/TEEsavR23oF.basis.glb" instead. The split follows from the number:
/// train below 800, val below 900, test below 1,000; no folder of a split for larger ones.
std::string scene_of_scan(std::string_view scan, std::string_view folder);

/// An episode. What test splits hide has no value.
struct ContinuousEpisode {
  FileId id, trajectory_id;  ///< the trajectory's is R2R's or RxR's path_id
  std::string scene;         ///< as written: "mp3d/zsNo4HB9uLZ/zsNo4HB9uLZ.glb"; may be absolute
  Vec3d start;               ///< the floor under the body
  StartRotation rotation;
  std::optional<EpisodeInfo> info = {};
  std::optional<std::vector<ContinuousGoal>> goals = {};  ///< one at least
  ContinuousInstruction instruction = {};
  std::optional<std::vector<Vec3d>> reference_path = {};  ///< start to goal; one point at least
  OtherFields others = {};

  /// scan_of_scene(). Valid as long as *this.
  std::string_view scan() const noexcept { return scan_of_scene(scene); }
  /// In [0, 2 pi). \pre rotation is one
  Radians start_heading() const { return rotation.heading(); }
  bool goal_hidden() const noexcept { return !goals.has_value(); }
  friend bool operator==(const ContinuousEpisode&, const ContinuousEpisode&) = default;
};

/// `instruction_vocab`: the meaning of the tokens.
struct InstructionVocabulary {
  std::vector<std::string> words;  ///< by token; may be empty
  std::optional<std::int64_t> size = {}, unknown = {},
                              padding = {};  ///< num_vocab, UNK_, PAD_INDEX
  OtherFields others = {};  ///< `word2idx_dict`, `stoi`, `itos`: the same words again
  friend bool operator==(const InstructionVocabulary&, const InstructionVocabulary&) = default;
};

/// A whole file.
struct ContinuousEpisodes {
  std::string split;  ///< "train", "val_seen", ...
  std::string file;
  std::vector<ContinuousEpisode> episodes;  ///< in its order
  std::optional<InstructionVocabulary> vocabulary = {};
  OtherFields others = {};
};

/// Whether the goal of any episode is hidden, as in test splits.
bool goals_hidden(const ContinuousEpisodes& episodes) noexcept;

/// Reads `<split>.json.gz` of R2R-CE, `<split>_<role>.json.gz` of RxR-CE, packed or not. Fields
/// that the model does not have are kept; null is read as no value where a field may be absent. One
/// episode is parsed at a time, of at most 4 MiB.
/// \throws FileError
/// \throws InvalidInput listing its faults (up to 1000) with their JSON paths:
///   - not JSON; missing, repeated or wrongly typed fields
///   - an id that another episode has, or that is neither a whole number nor an id (core/names.h)
///   - a scene without a name
///   - points of other than three numbers, or beyond kMostMetres (core/numbers.h)
///   - a rotation that is not one about the vertical axis
///   - an empty list of goals or path
///   - a negative distance, radius or token
///   - a role that RxR does not have
ContinuousEpisodes load_continuous_episodes(const std::filesystem::path& file, std::string split);
/// The same of a text. \param file  for messages
ContinuousEpisodes parse_continuous_episodes(std::string_view json, const std::string& file,
                                             std::string split);

/// The text of such a file, one episode per line. Its JSON values equal those of the file that was
/// read. Fields that were null are missing, and so are fields of timed words other than their
/// three.
/// parse_continuous_episodes() reads it back equal.
/// \throws ArgumentError for an infinite number, text that is not UTF-8, or a field among `others`
/// that is not JSON or has a name of the model's
std::string to_json(const ContinuousEpisodes& episodes);

/// What an expert did in an episode (`<split>_gt.json.gz`).
struct ExpertWalk {
  std::vector<Vec3d> locations;       ///< the start, then one for each step forward
  std::int64_t forward_steps = 0;     ///< as the file says
  std::vector<std::uint8_t> actions;  ///< 0 stop, 1 forward, 2 left, 3 right; RxR-CE: 4 up, 5 down
  OtherFields others = {};
  friend bool operator==(const ExpertWalk&, const ExpertWalk&) = default;
};

/// By text_of() an episode's id.
using ExpertWalks = std::map<std::string, ExpertWalk, std::less<>>;

/// Reads a file of experts' walks, packed or not.
/// Whether actions, steps and locations agree is not checked.
/// \throws FileError
/// \throws InvalidInput listing its faults with their JSON paths: as load_continuous_episodes(), an
/// action beyond 5, no location, a negative number of steps, a repeated episode
ExpertWalks load_expert_walks(const std::filesystem::path& file);
/// The same of a text. \param file  for messages
ExpertWalks parse_expert_walks(std::string_view json, const std::string& file);
/// The text of such a file, which parse_expert_walks() reads back equal, in the order of the map.
/// \throws ArgumentError as above
std::string to_json(const ExpertWalks& walks);

}  // namespace enfilade::tasks
