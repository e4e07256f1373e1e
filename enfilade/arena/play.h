/// \file  Episodes stepped through one after another by an outside caller: an assistant over a
/// protocol, a loop in Python, a person.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/arena/pictures.h"
#include "enfilade/arena/prompt.h"
#include "enfilade/arena/session.h"
#include "enfilade/arena/wire.h"
#include "enfilade/arena/world.h"
#include "enfilade/core/part_file.h"

namespace enfilade::arena {

/// The episodes, and the files that are written.
struct PlayConfig {
  std::vector<std::size_t> episodes;  ///< in this order; those with a transcript are left out
  SessionLimits limits = {};
  std::optional<Answers> answers = {};       ///< none: as the prompt has it
  std::optional<PictureKind> pictures = {};  ///< none: as the prompt has it
  std::uint32_t picture_size = 512;          ///< pixels, 64 to 2048
  /// For transcripts/ and results.json, as ask() writes them; empty: nothing is written.
  std::filesystem::path folder = {};
};

/// Result of a call.
struct PlayOutcome {
  bool carried_out = false;
  std::optional<Ending> ending = {};  ///< of the episode; no value: it goes on
  std::string told;                   ///< a sentence
};

/// One episode after another. One thread at a time.
///
///     arena::Play play(std::make_unique<arena::GraphWorld>(episodes), {},
///     arena::Prompt::named("text"),
///                      {.episodes = {0, 1}});
///     while (play.begin()) {
///       while (play.session() != nullptr) play.call(play.read(model(play.step_text())));
///     }
class Play {
 public:
  /// \param sights for pictures; may be empty if there are none
  /// \throws ArgumentError for null, no episode, an index, limits or sizes out of range, or
  /// pictures without sights
  /// \throws FileError, also if another process works in the folder
  Play(std::unique_ptr<World> world, const ViewSources& sights, Prompt prompt, PlayConfig config);

  /// Begins the next unfinished episode; false: all are finished. An episode in progress is dropped
  /// and begins again.
  /// \throws as World::start()
  bool begin();
  /// Begins an episode, also a finished one; the last trajectory counts.
  /// \throws ArgumentError for one that is not in PlayConfig::episodes; as begin()
  void begin_at(std::size_t episode);
  /// The session in progress; null before begin() and after its end.
  const Session* session() const noexcept { return session_.get(); }

  /// World::tools()
  std::vector<ToolUse> tools() const { return world_->tools(); }

  /// The prompt's texts for the session. \pre session() != nullptr
  std::string start_text() const;
  std::string step_text() const;
  /// The pictures that belong to step_text(), JPEG. \pre session() != nullptr
  /// \throws as PictureMaker
  std::vector<std::string> draw();

  /// Reads an answer: for kTools a JSON object of `name` and `arguments`, as in a tool call of
  /// OpenAI's form. Else as read_answer_json() and read_answer_text().
  Reading read(std::string_view answer) const;
  /// Performs a call. An unreadable answer is a mistake, and does nothing else. At the episode's
  /// end, transcript and results are written.
  /// \pre session() != nullptr
  /// \throws FileError if they cannot be written
  PlayOutcome call(const Reading& reading);

  Answers answers() const noexcept { return answers_; }
  std::size_t done() const;  ///< episodes, also by earlier processes in the folder
  std::size_t size() const noexcept { return config_.episodes.size(); }  ///< episodes in all
  /// PlayConfig::episodes
  const std::vector<std::size_t>& episodes() const noexcept { return config_.episodes; }
  /// The results of all finished episodes, in the form of the benchmark's results files.
  /// \throws FileError
  std::string results() const;
  /// The same for one that this object has finished. \throws ArgumentError for others
  std::string result(std::size_t episode) const;

 private:
  std::filesystem::path file_of(std::size_t episode) const;
  bool is_done(std::size_t episode) const;
  void start(std::size_t episode);
  void keep();

  PlayConfig config_;
  Prompt prompt_;
  Answers answers_;
  PictureKind pictures_;
  std::unique_ptr<World> world_;
  std::unique_ptr<PictureMaker> painter_;
  std::unique_ptr<FolderLock> lock_;
  std::unique_ptr<Session> session_;
  std::string transcript_;
  std::vector<PastStep> past_;
  std::map<std::size_t, std::string> walked_here_;  // what results files have of it, by episode
};

}  // namespace enfilade::arena
