#include <fmt/format.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "enfilade/core/file.h"
#include "enfilade/exports/detail/file_names.h"
#include "enfilade/exports/detail/walk_frames.h"
#include "enfilade/exports/expert_walks.h"

namespace enfilade::exports {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t kMostEqual = 3;  // actions in one decision

std::string answer(std::uint8_t action, std::size_t count, const continuous::SimulatorConfig& by) {
  const auto times = [&](double one) { return static_cast<double>(count) * one; };
  switch (action) {
    case 1:
      return fmt::format("The next action is move forward {:.0f} cm.", times(100 * by.forward));
    case 2:
      return fmt::format("The next action is turn left {:.0f} degree.", times(to_degrees(by.turn)));
    case 3:
      return fmt::format("The next action is turn right {:.0f} degree.",
                         times(to_degrees(by.turn)));
    default:
      return "I think I should stop because I have finished the instruction.";
  }
}

// An entry for each decision of a walk, a line each.
void annotate(const tasks::ContinuousResult& walk, const tasks::ContinuousEpisode& episode,
              const continuous::SimulatorConfig& simulator, std::string& text) {
  const std::string id = tasks::text_of(episode.id);
  Json frames = Json::array();
  std::size_t decision = 0;
  for (std::size_t k = 0; k < walk.actions.size();) {
    std::size_t equal = 1;
    while (equal < kMostEqual && k + equal < walk.actions.size() &&
           walk.actions[k + equal] == walk.actions[k]) {
      ++equal;
    }
    while (frames.size() <= k) frames.push_back(fmt::format("{}/frame_{}.jpg", id, frames.size()));
    text += text.size() > 1 ? ",\n" : "\n";
    text += Json{{"video_id", fmt::format("{}-{}", id, decision)},
                 {"q", episode.instruction.text},
                 {"a", answer(walk.actions[k], equal, simulator)},
                 {"frames", frames}}
                .dump();
    ++decision;
    k += equal;
  }
}

}  // namespace

WalkReport write_navila(const ExpertWalks& walks, const fs::path& folder,
                        const WalkPictures& pictures, const ExportOptions& options) {
  const detail::Walked walked = detail::walk_as_expert("navila", walks, folder, pictures);
  const fs::path base = folder / (pictures.data == "rxr" ? "RxR" : "R2R");
  const auto episode_of = [&](std::size_t k) -> const tasks::ContinuousEpisode& {
    return walks.episodes.episodes.at(walked.walks[k].episode);
  };
  const auto folder_of = [&](std::size_t k) {
    return base / walks.episodes.split /
           detail::checked_file_name(tasks::text_of(episode_of(k).id));
  };
  make_folder(base / walks.episodes.split);
  const WalkReport report = detail::draw_walks(
      walked, walks, pictures, options,
      {[&](std::size_t k) { return file_exists(folder_of(k)); },
       [&](std::size_t k, const detail::DrawnWalk& drawn) {
         detail::write_picture_folder(folder_of(k), drawn,
                                      [](std::size_t i) { return fmt::format("frame_{}.jpg", i); });
       }});
  std::string text = "[";
  for (std::size_t k = 0; k < walked.walks.size(); ++k) {
    annotate(walked.walks[k], episode_of(k), walks.simulator, text);
  }
  write_file_atomically(base / "annotations.json", text + "\n]\n");
  return report;
}

}  // namespace enfilade::exports
