/// \file  The text of a session's transcript: a line of JSON for the episode, one per call, one for
/// the end. It does not depend on time or computer.
#pragma once
#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "enfilade/arena/world.h"

namespace enfilade::arena::detail {

class Transcript {
 public:
  explicit Transcript(const Session& session);
  /// \param before the observation before the call  \param call null: none could be read
  /// \param more fields of the line, before `told`
  void add(const Observation& before, const Call* call, const Session& after,
           const nlohmann::ordered_json& more = nlohmann::ordered_json::object());
  /// The whole text. \pre the session has ended
  std::string finish(const Session& session, const World& world) &&;

 private:
  std::string text_;
};

/// The last line of a whole transcript. \throws FileError; InvalidInput if it has none
nlohmann::ordered_json end_of_transcript(const std::filesystem::path& file);

/// Writes results.json of those of the episodes that have a transcript; nothing if none has.
/// \returns the ends of their transcripts
std::vector<nlohmann::ordered_json> write_results(const std::filesystem::path& folder,
                                                  const World& world,
                                                  const std::vector<std::size_t>& which);

/// "FOLDER/transcripts/<id>.jsonl", with what file names should not have as "%3a".
std::filesystem::path transcript_file(const std::filesystem::path& folder, const World& world,
                                      std::size_t episode);

/// \throws ArgumentError naming an index that the world does not have
void check_episodes(const World& world, const std::vector<std::size_t>& which);

}  // namespace enfilade::arena::detail
