#include "enfilade/exports/detail/walk_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <numeric>
#include <span>
#include <system_error>
#include <utility>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/continuous/eyes.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/threads.h"
#include "enfilade/image/codecs.h"

namespace enfilade::exports {

std::vector<image::Image8> draw_poses(const tasks::ContinuousResult& walk,
                                      std::span<const std::size_t> poses, continuous::Eyes& eyes,
                                      const Camera& camera, double eye_height) {
  std::vector<continuous::MeshView> views;
  for (const std::size_t k : poses) {
    Vec3d eye = to_double(walk.positions[k]);
    eye.z += eye_height;
    views.push_back(
        {.building = 0, .eye = eye, .heading = walk.headings[k], .elevation = Radians(0)});
  }
  std::vector<image::Image8> pictures(views.size(), image::Image8(camera.width, camera.height, 3));
  const std::size_t bytes = std::size_t{3} * camera.width * camera.height;
  std::vector<std::byte> pixels(views.size() * bytes);
  render::Outputs outputs;
  outputs.colour = render::ColourOutput{render::ColourFormat::kRgb8, {}, pixels};
  eyes.render(camera, views, outputs);
  for (std::size_t k = 0; k < pictures.size(); ++k) {
    std::ranges::transform(std::span(pixels).subspan(k * bytes, bytes), pictures[k].pixels.begin(),
                           [](std::byte b) { return static_cast<std::uint8_t>(b); });
  }
  return pictures;
}

}  // namespace enfilade::exports

namespace enfilade::exports::detail {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kViewsAtOnce = 16;

// What would change the pictures.
std::string description(std::string_view form, const WalkPictures& o,
                        const continuous::SimulatorConfig& s) {
  nlohmann::ordered_json all{
      {"form", form},
      {"width", o.camera.width},
      {"height", o.camera.height},
      {"vertical_field_of_view", to_degrees(o.camera.vertical_field_of_view)},
      {"quality", o.quality},
      {"eye_height", s.eye_height},
      {"data", o.data}};
  // Folders of before there was a choice are the mesh's, and can be completed.
  if (o.appearance != continuous::Appearance::kMesh) {
    all["appearance"] = continuous::to_string(o.appearance);
  }
  return all.dump(1) + "\n";
}

void claim_folder(const fs::path& folder, const std::string& is) {
  make_folder(folder);
  const fs::path file = folder / "enfilade_export.json";
  if (!file_exists(file)) {
    write_file_atomically(file, is);
  } else if (read_file(file) != is) {
    throw FileError(fmt::format("{}: the folder has pictures of other options; take another folder",
                                file.string()));
  }
}

void check_paths(const tasks::ContinuousEpisodes& episodes) {
  for (const tasks::ContinuousEpisode& e : episodes.episodes) {
    if (!e.reference_path) {
      throw ArgumentError(fmt::format("episode {} of {} has no reference path for an expert",
                                      tasks::text_of(e.id), episodes.file));
    }
  }
}

// Sums of all pixels so far; whole numbers, so the order of the pictures does not count.
class PixelSums {
 public:
  void add(std::span<const std::uint8_t> rgb) {
    for (std::size_t i = 0; i + 2 < rgb.size(); i += 3) {
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint8_t value = rgb[i + c];
        least_[c] = std::min(least_[c], value);
        most_[c] = std::max(most_[c], value);
        sum_[c] += value;
        squares_[c] += std::uint64_t{value} * value;
      }
    }
    count_ += rgb.size() / 3;
  }
  PixelStatistics statistics() const {
    PixelStatistics result;
    for (std::size_t c = 0; c < 3; ++c) {
      const double n = static_cast<double>(count_);
      const double mean = static_cast<double>(sum_[c]) / n;
      result.least[c] = least_[c] / 255.0;
      result.most[c] = most_[c] / 255.0;
      result.mean[c] = mean / 255;
      result.deviation[c] =
          std::sqrt(std::max(0.0, static_cast<double>(squares_[c]) / n - mean * mean)) / 255;
    }
    return result;
  }

 private:
  std::array<std::uint8_t, 3> least_{255, 255, 255}, most_{};
  std::array<std::uint64_t, 3> sum_{}, squares_{};
  std::uint64_t count_ = 0;
};

DrawnWalk draw(const tasks::ContinuousResult& walk, const tasks::ContinuousEpisode& episode,
               double eye_height, const WalkPictures& pictures, continuous::Eyes& eyes) {
  DrawnWalk drawn{walk, episode, {}, {}};
  PixelSums sums;
  std::vector<std::size_t> poses(walk.actions.size());
  std::iota(poses.begin(), poses.end(), 0);
  for (std::size_t first = 0; first < poses.size(); first += kViewsAtOnce) {
    const auto some = std::span(poses).subspan(first, std::min(kViewsAtOnce, poses.size() - first));
    for (const image::Image8& one : draw_poses(walk, some, eyes, pictures.camera, eye_height)) {
      sums.add(one.pixels);
      const std::vector<std::uint8_t> file = image::encode_jpeg(one, pictures.quality);
      drawn.pictures.emplace_back(file.begin(), file.end());
    }
  }
  drawn.pixels = sums.statistics();
  return drawn;
}

}  // namespace

Walked walk_as_expert(std::string_view form, const ExpertWalks& walks, const fs::path& folder,
                      const WalkPictures& pictures) {
  validate(pictures.camera);
  check_range("quality", pictures.quality, 1, 100);
  check_paths(walks.episodes);
  const auto expert = agents::make_continuous_agent("reference");  // as record_experts() has
  Walked walked;
  walked.walks =
      agents::run_continuous(*expert, walks.episodes, walks.buildings,
                             {.batch_size = 64, .seed = 1, .simulator = walks.simulator});
  walked.too_long = std::erase_if(walked.walks, [&](const tasks::ContinuousResult& walk) {
    return walk.actions.size() > pictures.most_actions;
  });
  claim_folder(folder, description(form, pictures, walks.simulator));
  return walked;
}

WalkReport draw_walks(const Walked& walked, const ExpertWalks& walks, const WalkPictures& pictures,
                      const ExportOptions& options, const WalkStore& store) {
  WalkReport report;
  report.too_long = walked.too_long;
  std::mutex mutex;
  const auto count = [&](std::size_t k, bool kept) {
    const std::lock_guard lock(mutex);
    ++report.episodes;
    report.kept += kept ? 1 : 0;
    report.pictures += walked.walks[k].actions.size();
    if (options.progress) options.progress(report.episodes, walked.walks.size());
  };
  const auto episode_of = [&](std::size_t k) -> const tasks::ContinuousEpisode& {
    return walks.episodes.episodes.at(walked.walks[k].episode);
  };
  std::map<std::string, std::vector<std::size_t>> missing;
  for (std::size_t k = 0; k < walked.walks.size(); ++k) {
    if (store.has(k)) {
      count(k, true);
    } else {
      missing[std::string(episode_of(k).scan())].push_back(k);
    }
  }
  for (const auto& [scan, list] : missing) {
    const BuildingLook look = walks.look_of(scan);
    const bool panoramas = pictures.appearance == continuous::Appearance::kPanoramas;
    if (panoramas != (look.photographs != nullptr)) {
      throw ArgumentError(fmt::format("{}: its look does not fit the appearance \"{}\"", scan,
                                      continuous::to_string(pictures.appearance)));
    }
    parallel_for(list.size(), 1, options.threads, [&](std::size_t first, std::size_t last) {
      continuous::Eyes eyes({look.scene}, {.threads = 1, .photographs = {look.photographs}});
      for (std::size_t i = first; i < last; ++i) {
        const std::size_t k = list[i];
        store.write(
            k, draw(walked.walks[k], episode_of(k), walks.simulator.eye_height, pictures, eyes));
        count(k, false);
      }
    });
  }
  return report;
}

void write_picture_folder(const fs::path& folder, const DrawnWalk& walk,
                          const std::function<std::string(std::size_t)>& name) {
  fs::path part = folder;
  part += ".part";
  std::error_code none;
  fs::remove_all(part, none);
  for (std::size_t k = 0; k < walk.pictures.size(); ++k) {
    const fs::path file = part / name(k);
    make_folder(file.parent_path());
    write_file_atomically(file, walk.pictures[k]);
  }
  std::error_code failed;
  fs::rename(part, folder, failed);
  if (failed) throw FileError(fmt::format("{}: {}", folder.string(), failed.message()));
}

}  // namespace enfilade::exports::detail
