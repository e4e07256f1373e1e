#include "enfilade/homes/benchmarks/derived.h"

#include <array>
#include <cstdint>
#include <string>

#include "enfilade/tasks/tokenizer.h"

namespace enfilade::homes::benchmarks {

tasks::PathAnnotation last_sentences(tasks::PathAnnotation path) {
  for (std::string& text : path.instructions) {
    const std::size_t stop = text.rfind(". ");  // the text itself ends with a full stop
    if (stop != std::string::npos) text.erase(0, stop + 2);
  }
  return path;
}

tasks::PathAnnotation there_and_back(tasks::PathAnnotation path) {
  constexpr std::array<const char*, 3> kBack{" Then return to the place where you started.",
                                             " Afterwards go back to the start the way you came.",
                                             " After that, walk back to where you began."};
  for (std::size_t k = 0; k < path.instructions.size(); ++k) {
    path.instructions[k] += kBack.at((k + static_cast<std::size_t>(path.path_id)) % kBack.size());
  }
  if (path.path.empty()) return path;
  path.goal = tasks::NamedTurningPoint{path.path.back()};
  for (std::size_t i = path.path.size() - 1; i > 0; --i) path.path.push_back(path.path[i - 1]);
  if (path.distance) *path.distance *= 2;
  return path;
}

tasks::PathAnnotation in_pieces(tasks::PathAnnotation path,
                                const std::vector<std::vector<instructions::SpokenPart>>& spoken) {
  path.details.clear();
  for (const std::vector<instructions::SpokenPart>& instruction : spoken) {
    tasks::InstructionDetails& details = path.details.emplace_back();
    for (const instructions::SpokenPart& part : instruction) {
      details.parts.push_back({tasks::tokenize(part.text), std::pair(part.first, part.last)});
    }
  }
  return path;
}

}  // namespace enfilade::homes::benchmarks
