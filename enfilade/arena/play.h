/// \file  Episodes stepped through one after another by an outside caller: an assistant over a
/// protocol, a loop in Python, a person.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
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

namespace enfilade::arena {

/// The episodes, and the files that are written.
struct PlayConfig {
  std::vector<std::size_t> episodes;  ///< in this order; those with a transcript are left out
  Limits limits = {};
  std::optional<Answers> answers = {};    ///< none: as the prompt has it
  std::optional<Pictures> pictures = {};  ///< none: as the prompt has it
  std::uint32_t picture_size = 512;       ///< pixels, 64 to 2048
  /// For transcripts/ and results.json, as ask() writes them; empty: nothing is written.
  std::filesystem::path folder = {};
};

/// Result of a call.
struct Outcome {
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
  Play(std::unique_ptr<World> world, Sights sights, Prompt prompt, PlayConfig config);
  ~Play();
  Play(const Play&) = delete;
  Play& operator=(const Play&) = delete;

  /// Begins the next unfinished episode; false: all are finished. An episode in progress is dropped
  /// and begins again.
  /// \throws as World::start()
  bool begin();
  /// Begins an episode, also a finished one; the last trajectory counts.
  /// \throws ArgumentError for one that is not in PlayConfig::episodes; as begin()
  void begin_at(std::size_t episode);
  /// The session in progress; null before begin() and after its end.
  const Session* session() const noexcept;

  /// The prompt's texts for the session. \pre session() != nullptr
  std::string start_text() const;
  std::string step_text() const;
  /// The pictures that belong to step_text(), JPEG. \pre session() != nullptr
  /// \throws as Painter
  std::vector<std::string> draw();

  /// Reads an answer: for kTools a JSON object of `name` and `arguments`, as in a tool call of
  /// OpenAI's form. Else as read_answer_json() and read_answer_text().
  Reading read(std::string_view answer) const;
  /// Performs a call. An unreadable answer is a mistake, and does nothing else. At the episode's
  /// end, transcript and results are written.
  /// \pre session() != nullptr
  /// \throws FileError if they cannot be written
  Outcome call(const Reading& reading);

  Answers answers() const noexcept;
  std::size_t done() const noexcept;  ///< episodes, also by earlier processes in the folder
  std::size_t size() const noexcept;  ///< episodes in all
  const std::vector<std::size_t>& episodes() const noexcept;  ///< PlayConfig::episodes
  /// The results of all finished episodes, in the form of the benchmark's results files.
  /// \throws FileError
  std::string results() const;
  /// The same for one that this object has finished. \throws ArgumentError for others
  std::string result(std::size_t episode) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::arena
