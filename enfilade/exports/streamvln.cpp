#include "enfilade/exports/streamvln.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/continuous/eyes.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/threads.h"
#include "enfilade/image/image.h"

namespace enfilade::exports {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t kViewsAtOnce = 16;

// What would change the pictures.
std::string description(const StreamVlnOptions& o, const continuous::SimulatorConfig& s) {
  return Json{{"form", "streamvln"},
              {"width", o.camera.width},
              {"height", o.camera.height},
              {"vertical_field_of_view", to_degrees(o.camera.vertical_field_of_view)},
              {"quality", o.quality},
              {"eye_height", s.eye_height},
              {"data", o.data}}
             .dump(1) +
         "\n";
}

void claim_folder(const fs::path& folder, const std::string& is) {
  make_folder(folder / "images");
  const fs::path file = folder / "enfilade_export.json";
  if (!file_exists(file)) {
    write_file_atomically(file, is);
  } else if (read_file(file) != is) {
    throw FileError(fmt::format("{}: the folder has pictures of other options; take another folder",
                                file.string()));
  }
}

std::map<std::string, std::vector<Vec3d>, std::less<>> routes_of(
    const tasks::ContinuousEpisodes& episodes) {
  std::map<std::string, std::vector<Vec3d>, std::less<>> routes;
  for (const tasks::ContinuousEpisode& e : episodes.episodes) {
    if (!e.reference_path) {
      throw ArgumentError(fmt::format("episode {} of {} has no reference path for an expert",
                                      tasks::text_of(e.id), episodes.file));
    }
    routes[tasks::text_of(e.id)] = *e.reference_path;
  }
  return routes;
}

// Six digits of a number, an id that is none as it is.
std::string digits(const std::string& id) {
  const bool number =
      !id.empty() && std::ranges::all_of(id, [](char c) { return c >= '0' && c <= '9'; });
  return number ? fmt::format("{:0>6}", id) : id;
}

class Writer {
 public:
  Writer(const tasks::ContinuousEpisodes& episodes, const continuous::SimulatorConfig& simulator,
         const fs::path& folder, const StreamVlnOptions& pictures, const ExportOptions& options)
      : episodes_(episodes),
        simulator_(simulator),
        folder_(folder),
        pictures_(pictures),
        options_(options) {}

  StreamVlnReport run(const std::vector<tasks::ContinuousResult>& walks,
                      const SceneOfScan& scene_of) {
    std::map<std::string, std::vector<const tasks::ContinuousResult*>> by_scan;
    for (const tasks::ContinuousResult& walk : walks) {
      if (walk.actions.size() > pictures_.most_actions) {
        ++report_.too_long;
      } else {
        by_scan[std::string(episode_of(walk).scan())].push_back(&walk);
      }
    }
    total_ = walks.size() - report_.too_long;
    for (const auto& [scan, list] : by_scan) write_scan(scan, list, scene_of);
    write_annotations(walks);
    return report_;
  }

 private:
  const tasks::ContinuousEpisode& episode_of(const tasks::ContinuousResult& walk) const {
    return episodes_.episodes.at(walk.episode);
  }
  std::string name_of(const tasks::ContinuousResult& walk) const {
    const tasks::ContinuousEpisode& e = episode_of(walk);
    return fmt::format("{}_{}_{}", e.scan(), pictures_.data, digits(tasks::text_of(e.id)));
  }
  fs::path folder_of(const tasks::ContinuousResult& walk) const {
    return folder_ / "images" / name_of(walk);
  }
  // A picture before each action; the last one is before stop.
  static std::size_t frames(const tasks::ContinuousResult& walk) { return walk.actions.size(); }

  void write_scan(const std::string& scan, const std::vector<const tasks::ContinuousResult*>& walks,
                  const SceneOfScan& scene_of) {
    std::vector<const tasks::ContinuousResult*> missing;
    for (const tasks::ContinuousResult* walk : walks) {
      if (file_exists(folder_of(*walk))) {
        count(*walk, true);
      } else {
        missing.push_back(walk);
      }
    }
    if (missing.empty()) return;
    const std::shared_ptr<const continuous::Scene> scene = scene_of(scan);
    parallel_for(missing.size(), 1, options_.threads, [&](std::size_t first, std::size_t last) {
      continuous::Eyes eyes({scene}, {.threads = 1});
      for (std::size_t k = first; k < last; ++k) {
        write_walk(*missing[k], eyes);
        count(*missing[k], false);
      }
    });
  }

  void count(const tasks::ContinuousResult& walk, bool kept) {
    const std::lock_guard lock(mutex_);
    ++report_.episodes;
    report_.kept += kept ? 1 : 0;
    report_.pictures += frames(walk);
    if (options_.progress) options_.progress(report_.episodes, total_);
  }

  void write_walk(const tasks::ContinuousResult& walk, continuous::Eyes& eyes) const {
    fs::path part = folder_of(walk);
    part += ".part";
    std::error_code none;
    fs::remove_all(part, none);
    make_folder(part / "rgb");
    for (std::size_t first = 0; first < frames(walk); first += kViewsAtOnce) {
      write_frames(walk, first, std::min(kViewsAtOnce, frames(walk) - first), part / "rgb", eyes);
    }
    std::error_code failed;
    fs::rename(part, folder_of(walk), failed);
    if (failed) {
      throw FileError(fmt::format("{}: {}", folder_of(walk).string(), failed.message()));
    }
  }

  void write_frames(const tasks::ContinuousResult& walk, std::size_t first, std::size_t count,
                    const fs::path& to, continuous::Eyes& eyes) const {
    std::vector<continuous::MeshView> views;
    for (std::size_t k = first; k < first + count; ++k) {
      Vec3d eye = to_double(walk.positions[k]);
      eye.z += simulator_.eye_height;
      views.push_back(
          {.building = 0, .eye = eye, .heading = walk.headings[k], .elevation = Radians(0)});
    }
    const std::uint32_t width = pictures_.camera.width, height = pictures_.camera.height;
    const std::size_t bytes = std::size_t{3} * width * height;
    std::vector<std::byte> pixels(count * bytes);
    render::Outputs outputs;
    outputs.colour = render::ColourOutput{render::ColourFormat::kRgb8, {}, pixels};
    eyes.render(pictures_.camera, views, outputs);
    for (std::size_t k = 0; k < count; ++k) {
      image::Image8 picture(width, height, 3);
      std::transform(pixels.begin() + static_cast<std::ptrdiff_t>(k * bytes),
                     pixels.begin() + static_cast<std::ptrdiff_t>((k + 1) * bytes),
                     picture.pixels.begin(),
                     [](std::byte b) { return static_cast<std::uint8_t>(b); });
      image::save((to / fmt::format("{:03}.jpg", first + k + 1)).string(), picture,
                  pictures_.quality);
    }
  }

  void write_annotations(const std::vector<tasks::ContinuousResult>& walks) const {
    std::string text = "[";
    for (const tasks::ContinuousResult& walk : walks) {
      if (walk.actions.size() > pictures_.most_actions) continue;
      const tasks::ContinuousEpisode& e = episode_of(walk);
      Json actions = Json::array({-1});
      for (std::size_t k = 0; k + 1 < walk.actions.size(); ++k) actions.push_back(walk.actions[k]);
      Json entry{{"id", nullptr},
                 {"video", "images/" + name_of(walk)},
                 {"instructions", Json::array({e.instruction.text})},
                 {"actions", std::move(actions)}};
      std::visit([&](const auto& id) { entry["id"] = id; }, e.id);
      text += (text.size() > 1 ? ",\n" : "\n") + entry.dump();
    }
    write_file_atomically(folder_ / "annotations.json", text + "\n]\n");
  }

  const tasks::ContinuousEpisodes& episodes_;
  const continuous::SimulatorConfig& simulator_;
  const fs::path& folder_;
  const StreamVlnOptions& pictures_;
  const ExportOptions& options_;
  std::size_t total_ = 0;
  std::mutex mutex_;
  StreamVlnReport report_;
};

}  // namespace

StreamVlnReport write_streamvln(const tasks::ContinuousEpisodes& episodes,
                                const std::shared_ptr<const continuous::Buildings>& buildings,
                                const continuous::SimulatorConfig& simulator,
                                const SceneOfScan& scene_of, const fs::path& folder,
                                const StreamVlnOptions& pictures, const ExportOptions& options) {
  validate(pictures.camera);
  check_range("quality", pictures.quality, 1, 100);
  const auto expert = agents::make_route_agent("expert", routes_of(episodes));
  const auto walks = agents::run_continuous(*expert, episodes, buildings,
                                            {.batch_size = 64, .seed = 1, .simulator = simulator});
  claim_folder(folder, description(pictures, simulator));
  return Writer(episodes, simulator, folder, pictures, options).run(walks, scene_of);
}

}  // namespace enfilade::exports
