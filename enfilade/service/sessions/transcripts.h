/// \file  The files of runs: folders, descriptions, transcripts. They may come from any source, so
/// all that is read has limits. What messages say names no folder of this machine.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/arena/session.h"

namespace enfilade::service::sessions {

inline constexpr std::uintmax_t kMostTranscriptBytes = 16ULL << 20ULL;
inline constexpr std::size_t kMostTranscriptLines = 10'000;

/// The folder of a run, or the transcript of an episode, whose id is its name.
struct NamedPath {
  std::string name;
  std::filesystem::path path;
};

/// The runs in a folder, by name. A folder with transcripts/ is a run itself.
std::vector<NamedPath> run_folders(const std::filesystem::path& folder);
/// The transcripts of a run, in the order of their ids: by length, then by letters, so that 2_0 is
/// before 10_0.
std::vector<NamedPath> transcripts_in(const std::filesystem::path& run);
/// A JSON object of a run's folder: run.json, usage.json. No value: there is no such file.
/// Discarded if it is longer than 1 MiB, or no JSON object within the limits.
std::optional<nlohmann::ordered_json> read_run_file(const std::filesystem::path& file);
/// The instruction in the first line of a transcript, if it has one.
std::optional<std::string> instruction_in(const std::filesystem::path& transcript);
/// The text that an object has under a name, if it has one.
std::optional<std::string> text_in(const nlohmann::ordered_json& object, const char* name);

/// The beginning of a text: whole characters of at most that many bytes, and "…" where more
/// follows.
std::string beginning(std::string text, std::size_t most);

/// One call of a transcript.
struct TranscriptStep {
  nlohmann::ordered_json shown;  ///< the served part of the line
  std::optional<arena::Call> call;
  std::vector<std::string> pictures;  ///< arena::PictureOrder::key() of those that were sent
};
struct Transcript {
  std::string instruction;
  std::vector<TranscriptStep> steps;
  nlohmann::ordered_json end;  ///< {"ending", "steps", "mistakes", "reason"?}
  std::string result;          ///< the entry of results files, JSON; empty: none
};
/// \throws Refusal kInvalidInput naming file and line for what cannot be read
Transcript read_transcript(const std::filesystem::path& file);

/// What lists and sums have of a transcript.
struct TranscriptSummary {
  std::string instruction;              ///< empty: the first line has none
  std::optional<arena::Ending> ending;  ///< no value: the last line is no end
  std::string reason;                   ///< of the end, if the file has one
  std::uint64_t steps = 0;              ///< accepted calls
  std::uint64_t mistakes = 0;           ///< calls that were not, `unanswered` among them
  std::uint64_t unanswered = 0;         ///< answers without a call: empty, cut off, refused, ...
  std::uint64_t prompt_tokens = 0, answer_tokens = 0;
  std::string result;  ///< the entry of results files, JSON; empty: none
};
/// Lines that cannot be read count nothing. If a file exceeds the limits, only its end is read.
TranscriptSummary summarise_transcript(const std::filesystem::path& file);

}  // namespace enfilade::service::sessions
