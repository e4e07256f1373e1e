#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <variant>

#include "enfilade/core/file.h"
#include "enfilade/exports/detail/walk_frames.h"
#include "enfilade/exports/expert_walks.h"

namespace enfilade::exports {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Six digits of a number; another id unchanged.
std::string digits(const std::string& id) {
  const bool number =
      !id.empty() && std::ranges::all_of(id, [](char c) { return c >= '0' && c <= '9'; });
  return number ? fmt::format("{:0>6}", id) : id;
}

std::string video_of(const tasks::ContinuousEpisode& e, const WalkPictures& pictures) {
  return fmt::format("images/{}_{}_{}", e.scan(), pictures.data, digits(tasks::text_of(e.id)));
}

std::string annotation(const tasks::ContinuousResult& walk, const tasks::ContinuousEpisode& e,
                       const WalkPictures& pictures) {
  Json actions = Json::array({-1});
  for (std::size_t k = 0; k + 1 < walk.actions.size(); ++k) actions.push_back(walk.actions[k]);
  Json entry{{"id", nullptr},
             {"video", video_of(e, pictures)},
             {"instructions", Json::array({e.instruction.text})},
             {"actions", std::move(actions)}};
  std::visit([&](const auto& id) { entry["id"] = id; }, e.id);
  return entry.dump();
}

}  // namespace

WalkReport write_streamvln(const ExpertWalks& walks, const fs::path& folder,
                           const WalkPictures& pictures, const ExportOptions& options) {
  const detail::Walked walked = detail::walk_as_expert("streamvln", walks, folder, pictures);
  const auto episode_of = [&](std::size_t k) -> const tasks::ContinuousEpisode& {
    return walks.episodes.episodes.at(walked.walks[k].episode);
  };
  const auto folder_of = [&](std::size_t k) { return folder / video_of(episode_of(k), pictures); };
  make_folder(folder / "images");
  const WalkReport report =
      detail::draw_walks(walked, walks, pictures, options,
                         {[&](std::size_t k) { return file_exists(folder_of(k)); },
                          [&](std::size_t k, const detail::DrawnWalk& drawn) {
                            detail::write_picture_folder(folder_of(k), drawn, [](std::size_t i) {
                              return fmt::format("rgb/{:03}.jpg", i + 1);
                            });
                          }});
  std::string text = "[";
  for (std::size_t k = 0; k < walked.walks.size(); ++k) {
    text += (k > 0 ? ",\n" : "\n") + annotation(walked.walks[k], episode_of(k), pictures);
  }
  write_file_atomically(folder / "annotations.json", text + "\n]\n");
  return report;
}

}  // namespace enfilade::exports
