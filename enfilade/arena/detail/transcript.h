/// \file  The text of a session's transcript: a line of JSON for the episode, one per call, one for
/// the end. It does not depend on time or computer.
#pragma once
#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/arena/world.h"

namespace enfilade::arena::detail {

/// The first line.
std::string first_line(const Session& session);
/// A line per call. \param before  the observation before the call
/// \param call  no value: the answer had none
/// \param more  fields of the line, before `told`
std::string call_line(const SessionObservation& before, const std::optional<Call>& call,
                      const Session& after,
                      const nlohmann::ordered_json& more = nlohmann::ordered_json::object());
/// The last line. \param reason  of Ending::kRefused; empty for the others
/// \pre the session has ended
std::string end_line(const Session& session, const World& world, const std::string& reason = {});

/// Writes results.json of those of the episodes that have a transcript; nothing if none has.
/// \returns the ends of their transcripts
/// \throws FileError; InvalidInput for one without an end
std::vector<nlohmann::ordered_json> write_results(const std::filesystem::path& folder,
                                                  const World& world,
                                                  const std::vector<std::size_t>& which);

/// "FOLDER/transcripts/<id>.jsonl", with what file names should not have as "%3a".
std::filesystem::path transcript_file(const std::filesystem::path& folder, const World& world,
                                      std::size_t episode);

/// Writes that file. \throws FileError
void write_transcript(const std::filesystem::path& folder, const World& world, std::size_t episode,
                      const std::string& text);

/// \throws ArgumentError naming an index that the world does not have
void check_episodes(const World& world, const std::vector<std::size_t>& which);

}  // namespace enfilade::arena::detail
