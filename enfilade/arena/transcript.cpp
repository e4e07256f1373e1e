#include "enfilade/arena/detail/transcript.h"

#include <fmt/format.h>
#include <algorithm>
#include <utility>

#include "enfilade/arena/wire.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/output_folder.h"

namespace enfilade::arena::detail {

namespace {

using Json = nlohmann::ordered_json;

/// The last line of a whole transcript.
Json end_of_transcript(const std::filesystem::path& file) {
  const std::string text = read_file(file);
  const std::size_t before = text.find_last_not_of('\n');
  const std::size_t begin = before == std::string::npos ? 0 : text.rfind('\n', before) + 1;
  Json end = Json::parse(text.substr(begin), nullptr, false);
  const bool whole = end.is_object() && end.contains("result") && end.contains("mistakes") &&
                     end["mistakes"].is_number_unsigned() && end.contains("ending") &&
                     end["ending"].is_string() &&
                     find_enum<Ending>(end["ending"].get<std::string>()).has_value();
  if (!whole) {
    throw InvalidInput({{Severity::kError, file.string(), "the last line", "no-end",
                         "no end of an episode; remove the file, and it is walked again"}});
  }
  return end;
}

}  // namespace

std::string first_line(const Session& session) {
  return Json{{"episode", session.episode_id()}, {"instruction", session.observation().instruction}}
             .dump() +
         "\n";
}

std::string call_line(const SessionObservation& before, const std::optional<Call>& call,
                      const Session& after, const Json& more) {
  Json step{{"observation", Json::parse(to_json(before))}};
  step["call"] = call ? Json{{"tool", call->tool}, {"argument", call->argument}} : Json();
  step.update(more);
  step["told"] = after.observation().told;
  return step.dump() + "\n";
}

std::string end_line(const Session& session, const World& world, const std::string& reason) {
  Json end{{"ending", name_of(*session.ending())},
           {"steps", session.observation().step},
           {"mistakes", session.mistakes()}};
  if (!reason.empty()) end["reason"] = reason;
  end["result"] = Json::parse(world.result(session.walked()));
  return end.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::vector<Json> write_results(const std::filesystem::path& folder, const World& world,
                                const std::vector<std::size_t>& which) {
  std::vector<Json> ends;
  std::vector<std::string> entries;
  for (const std::size_t episode : which) {
    const auto file = transcript_file(folder, world, episode);
    if (!file_exists(file)) continue;
    ends.push_back(end_of_transcript(file));
    entries.push_back(ends.back()["result"].dump());
  }
  if (!entries.empty()) OutputFolder(folder).write("results.json", world.results(entries));
  return ends;
}

std::filesystem::path transcript_file(const std::filesystem::path& folder, const World& world,
                                      std::size_t episode) {
  std::string name;
  for (const char c : world.episodes().id(episode)) {
    const bool plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                       c == '-' || c == '_' || c == '.';
    name += plain ? std::string(1, c) : fmt::format("%{:02x}", static_cast<unsigned char>(c));
  }
  return folder / "transcripts" / (name + ".jsonl");
}

void write_transcript(const std::filesystem::path& folder, const World& world, std::size_t episode,
                      const std::string& text) {
  OutputFolder(folder).write(transcript_file({}, world, episode).string(), text);
}

void check_episodes(const World& world, const std::vector<std::size_t>& which) {
  for (const std::size_t one : which) {
    if (one < world.size()) continue;
    throw ArgumentError(fmt::format("episode: {}; there are {}", one, world.size()));
  }
}

}  // namespace enfilade::arena::detail
