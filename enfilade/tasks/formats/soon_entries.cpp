#include "enfilade/tasks/formats/soon_entries.h"

#include "enfilade/core/numbers.h"

namespace enfilade::tasks::formats {

std::optional<std::string_view> soon_start(json::Element answer) {
  constexpr int kDeepest = 3;  // [["v", h, e]], or groups of those
  json::Element at;
  if (answer["path"].get(at) != simdjson::SUCCESS) return std::nullopt;
  for (int depth = 0; depth < kDeepest; ++depth) {
    simdjson::dom::array list;
    if (at.get_array().get(list) != simdjson::SUCCESS || list.at(0).get(at) != simdjson::SUCCESS) {
      return std::nullopt;
    }
    std::string_view text;
    if (at.get_string().get(text) == simdjson::SUCCESS) return text;
  }
  return std::nullopt;
}

SoonEntries::SoonEntries(const EpisodeSet& episodes) : episodes_(episodes) {
  if (episodes.task != Task::kSoon) return;
  for (std::size_t i = 0; i < episodes.episodes.size(); ++i) {
    const Episode& episode = episodes.episodes[i];
    if (episode.details.entry) {
      entries_[*episode.details.entry][episode.instruction].push_back(i);
    }
  }
}

std::vector<const SoonEntries::Instruction*> SoonEntries::instructions_of(
    std::string_view id) const {
  std::vector<const Instruction*> found;
  if (const auto entry = entries_.find(id); entry != entries_.end()) {
    for (const auto& [k, instruction] : entry->second) found.push_back(&instruction);
    return found;
  }
  const std::size_t end = id.rfind('_');
  if (end == std::string_view::npos) return found;
  const auto number = parse_number<std::size_t>(id.substr(end + 1));
  const auto entry = entries_.find(id.substr(0, end));
  if (!number || entry == entries_.end()) return found;
  const auto instruction = entry->second.find(*number);
  if (instruction != entry->second.end()) found.push_back(&instruction->second);
  return found;
}

SoonEntries::Found SoonEntries::find(std::string_view id, std::string_view start,
                                     const std::function<bool(std::size_t)>& answered) const {
  Found found;
  for (const Instruction* instruction : instructions_of(id)) {
    for (const std::size_t episode : *instruction) {
      const ReferencePath& path = episodes_.path_of(episodes_.episodes[episode]);
      if (episodes_.graphs->graph(path.scan).id(path.viewpoints.front()) != start) continue;
      found.any = true;
      if (answered(episode)) continue;
      found.episode = episode;
      return found;
    }
  }
  return found;
}

}  // namespace enfilade::tasks::formats
