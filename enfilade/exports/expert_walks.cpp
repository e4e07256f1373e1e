#include "enfilade/exports/expert_walks.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/core/threads.h"
#include "enfilade/exports/detail/scan_parts.h"
#include "enfilade/image/codecs.h"

namespace enfilade::exports {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using tasks::ContinuousEpisode;
using tasks::ContinuousResult;

constexpr std::size_t kViewsAtOnce = 16;

/// Numbers of a trajectory's pictures before JPEG, by their names in LeRobot's files; 0 to 1.
using PixelStatistics = std::vector<std::pair<const char*, std::array<double, 3>>>;

/// One trajectory and its pictures.
struct DrawnWalk {
  const ContinuousResult& walk;
  std::vector<std::string> pictures = {};  ///< JPEG files, one before each action
  PixelStatistics pixels = {};
};

/// The trajectories of a form, in the order of the episodes; too long ones are left out.
struct Rollouts {
  const ExpertWalks& of;
  std::vector<ContinuousResult> walks = {};
  std::size_t too_long = 0;

  const ContinuousEpisode& episode(std::size_t k) const {
    return of.episodes.episodes.at(walks[k].episode);
  }
};

// What would change the pictures.
std::string description(std::string_view form, const WalkPictures& o,
                        const continuous::SimulatorConfig& s) {
  Json all{{"form", form},
           {"width", o.camera.width},
           {"height", o.camera.height},
           {"vertical_field_of_view", to_degrees(o.camera.vertical_field_of_view)},
           {"quality", o.quality},
           {"eye_height", s.eye_height},
           {"data", o.data}};
  // Folders of before there was a choice are the mesh's, and can be completed.
  if (o.appearance != continuous::Appearance::kMesh) {
    all["appearance"] = enum_name(o.appearance);
  }
  return all.dump(1) + "\n";
}

void claim_folder(const OutputFolder& folder, const std::string& is) {
  const fs::path file = folder.path() / "enfilade_export.json";
  if (!file_exists(file)) {
    folder.write("enfilade_export.json", is);
  } else if (read_file(file) != is) {
    throw FileError(fmt::format("{}: the folder has pictures of other options; take another folder",
                                file.string()));
  }
}

void check_paths(const tasks::ContinuousEpisodes& episodes) {
  for (const ContinuousEpisode& e : episodes.episodes) {
    if (!e.reference_path) {
      throw ArgumentError(fmt::format("episode {} of {} has no reference path for an expert",
                                      tasks::text_of(e.id), episodes.file));
    }
  }
}

// How often each value occurs in all pixels so far.
class PixelCounts {
 public:
  void add(std::span<const std::uint8_t> rgb) {
    for (std::size_t i = 0; i + 2 < rgb.size(); i += 3) {
      for (std::size_t c = 0; c < 3; ++c) ++channels_[c][rgb[i + c]];
    }
    pixels_ += rgb.size() / 3;
  }
  PixelStatistics statistics() const {
    constexpr std::array<std::pair<const char*, double>, 7> kRanks{{{"min", 0},
                                                                    {"q01", 0.01},
                                                                    {"q10", 0.1},
                                                                    {"q50", 0.5},
                                                                    {"q90", 0.9},
                                                                    {"q99", 0.99},
                                                                    {"max", 1}}};
    PixelStatistics result;
    for (const auto& [name, share] : kRanks) {
      std::array<double, 3>& values = result.emplace_back(name, std::array<double, 3>{}).second;
      std::ranges::transform(channels_, values.begin(),
                             [&](const Counts& counts) { return value_at(counts, share); });
    }
    std::array<double, 3> means{}, deviations{};
    for (std::size_t c = 0; c < 3; ++c) {
      std::uint64_t sum = 0, squares = 0;  // whole numbers: the order of the pictures has no effect
      for (std::size_t value = 0; value < channels_[c].size(); ++value) {
        sum += channels_[c][value] * value;
        squares += channels_[c][value] * value * value;
      }
      const double n = static_cast<double>(pixels_);
      const double mean = static_cast<double>(sum) / n;
      means[c] = mean / 255;
      deviations[c] =
          std::sqrt(std::max(0.0, static_cast<double>(squares) / n - mean * mean)) / 255;
    }
    result.emplace_back("mean", means);
    result.emplace_back("std", deviations);
    return result;
  }

 private:
  using Counts = std::array<std::uint64_t, 256>;

  // The least value that this share of the pixels does not exceed.
  double value_at(const Counts& counts, double share) const {
    const auto rank = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(pixels_)));
    std::uint64_t below = 0;
    std::size_t value = 0;
    while (value + 1 < counts.size() &&
           (below += counts[value]) < std::max<std::uint64_t>(rank, 1)) {
      ++value;
    }
    return static_cast<double>(value) / 255;
  }

  std::array<Counts, 3> channels_{};
  std::uint64_t pixels_ = 0;
};

DrawnWalk draw(const ContinuousResult& walk, double eye_height, const WalkPictures& pictures,
               continuous::Eyes& eyes) {
  DrawnWalk drawn{walk};
  PixelCounts counts;
  std::vector<std::size_t> poses(walk.actions.size());
  std::iota(poses.begin(), poses.end(), 0);
  for (std::size_t first = 0; first < poses.size(); first += kViewsAtOnce) {
    const auto some = std::span(poses).subspan(first, std::min(kViewsAtOnce, poses.size() - first));
    for (const image::Image8& one : draw_poses(walk, some, eyes, pictures.camera, eye_height)) {
      counts.add(one.pixels);
      const std::vector<std::uint8_t> file = image::encode_jpeg(one, pictures.quality);
      drawn.pictures.emplace_back(file.begin(), file.end());
    }
  }
  drawn.pixels = counts.statistics();
  return drawn;
}

/// Checks the options, runs the expert, and claims the folder for `form`.
Rollouts walk_as_expert(std::string_view form, const ExpertWalks& walks, const fs::path& folder,
                        const WalkPictures& pictures) {
  validate(pictures.camera);
  check_range("quality", pictures.quality, 1, 100);
  check_paths(walks.episodes);
  const auto expert = agents::make_continuous_agent("reference");  // as record_experts() has
  Rollouts walked{walks};
  walked.walks =
      agents::run_continuous(*expert, walks.episodes, walks.buildings,
                             {.batch_size = 64, .seed = 1, .simulator = walks.simulator});
  walked.too_long = std::erase_if(walked.walks, [&](const ContinuousResult& walk) {
    return walk.actions.size() > pictures.most_actions;
  });
  claim_folder(OutputFolder(folder), description(form, pictures, walks.simulator));
  return walked;
}

/// Renders trajectories that an earlier run has not stored, in parallel, one building after the
/// other.
/// \param has  whether an earlier run has stored number k
/// \param write  stores number k, whole or not at all; called from several threads
WalkReport draw_walks(const Rollouts& walked, const WalkPictures& pictures,
                      const ExportOptions& options, const std::function<bool(std::size_t)>& has,
                      const std::function<void(std::size_t, const DrawnWalk&)>& write) {
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
  std::map<std::string, std::vector<std::size_t>> missing;
  for (std::size_t k = 0; k < walked.walks.size(); ++k) {
    if (has(k)) {
      count(k, true);
    } else {
      missing[std::string(walked.episode(k).scan())].push_back(k);
    }
  }
  for (const auto& [scan, list] : missing) {
    const BuildingLook look = walked.of.look_of(scan);
    const bool panoramas = pictures.appearance == continuous::Appearance::kPanoramas;
    if (panoramas != (look.photographs != nullptr)) {
      throw ArgumentError(fmt::format("{}: its look does not fit the appearance \"{}\"", scan,
                                      enum_name(pictures.appearance)));
    }
    parallel_for(list.size(), 1, options.threads, [&](std::size_t first, std::size_t last) {
      continuous::Eyes eyes({look.scene}, {.threads = 1, .photographs = {look.photographs}});
      for (std::size_t i = first; i < last; ++i) {
        const std::size_t k = list[i];
        write(k, draw(walked.walks[k], walked.of.simulator.eye_height, pictures, eyes));
        count(k, false);
      }
    });
  }
  return report;
}

/// Writes pictures into `folder` of `out`, which appears when all are there.
/// \param name  of the k-th picture
void write_picture_folder(const OutputFolder& out, const std::string& folder, const DrawnWalk& walk,
                          const std::function<std::string(std::size_t)>& name) {
  const std::string part = folder + ".part";
  out.remove_all(part);
  for (std::size_t k = 0; k < walk.pictures.size(); ++k) {
    out.write(part + "/" + name(k), walk.pictures[k]);
  }
  out.rename(part, folder);
}

/// Renders each trajectory into a folder of its own. \param name  of the k-th picture
WalkReport draw_folders(const Rollouts& walked, const OutputFolder& out,
                        const WalkPictures& pictures, const ExportOptions& options,
                        const std::function<std::string(std::size_t)>& folder_of,
                        const std::function<std::string(std::size_t)>& name) {
  return draw_walks(
      walked, pictures, options,
      [&](std::size_t k) { return file_exists(out.path() / folder_of(k)); },
      [&](std::size_t k, const DrawnWalk& drawn) {
        write_picture_folder(out, folder_of(k), drawn, name);
      });
}

// --- the forms ---

// Six digits of a number; another id unchanged.
std::string digits(const std::string& id) {
  const bool number =
      !id.empty() && std::ranges::all_of(id, [](char c) { return c >= '0' && c <= '9'; });
  return number ? fmt::format("{:0>6}", id) : id;
}

std::string video_of(const ContinuousEpisode& e, const WalkPictures& pictures) {
  return "images/" + detail::checked_file_name(fmt::format("{}_{}_{}", e.scan(), pictures.data,
                                                           digits(tasks::text_of(e.id))));
}

std::string annotation(const ContinuousResult& walk, const ContinuousEpisode& e,
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
void annotate(const ContinuousResult& walk, const ContinuousEpisode& episode,
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

constexpr std::size_t kChunk = 1000;  // episodes in a folder

// Numbers of a trajectory: one row per picture, and statistics of the pictures.
std::string rows_text(const DrawnWalk& drawn) {
  const ContinuousResult& walk = drawn.walk;
  Json actions = Json::array();
  Json states = Json::array();
  for (std::size_t k = 0; k < walk.actions.size(); ++k) {
    const Vec3f& p = walk.positions[k];
    actions.push_back(walk.actions[k]);
    states.push_back(Json::array({p.x, p.y, p.z, static_cast<float>(walk.headings[k].value)}));
  }
  Json pixels = Json::object();
  for (const auto& [name, channels] : drawn.pixels) pixels[name] = channels;
  return Json{{"actions", std::move(actions)},
              {"states", std::move(states)},
              {"pixels", std::move(pixels)}}
             .dump() +
         "\n";
}

/// The tables that Python has written, or will write, of the parts of a data set of LeRobot.
class PlannedTables {
 public:
  /// \throws InvalidInput for a file that is not Python's
  explicit PlannedTables(const fs::path& folder, const fs::path& parts) : folder_(folder) {
    const fs::path file = parts / "tables.json";
    if (!file_exists(file)) return;
    const Json plan = Json::parse(read_file(file), nullptr, false);
    try {
      for (const Json& table : plan.at("tables")) {
        const auto first = table.at("first").get<std::size_t>();
        firsts_[first] = {first + table.at("count").get<std::size_t>(),
                          table.at("files").get<std::vector<std::string>>()};
      }
    } catch (const Json::exception&) {
      refuse(file.string(), "$.tables", "bad-plan",
             "not the plan of the tables; remove the file, and tables are written anew");
    }
  }
  /// Whether the rows of episode k are in files that exist.
  bool has(std::size_t k) const {
    auto found = firsts_.upper_bound(k);
    if (found == firsts_.begin()) return false;
    const Table& table = std::prev(found)->second;
    return k < table.end && std::ranges::all_of(table.files, [&](const std::string& name) {
             return file_exists(folder_ / name);
           });
  }

 private:
  struct Table {
    std::size_t end = 0;
    std::vector<std::string> files = {};
  };
  fs::path folder_;
  std::map<std::size_t, Table> firsts_;
};

}  // namespace

std::vector<image::Image8> draw_poses(const ContinuousResult& walk,
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

WalkReport write_streamvln(const ExpertWalks& walks, const fs::path& folder,
                           const WalkPictures& pictures, const ExportOptions& options) {
  const Rollouts walked = walk_as_expert("streamvln", walks, folder, pictures);
  const OutputFolder out(folder);
  static_cast<void>(out.folder("images"));
  const WalkReport report = draw_folders(
      walked, out, pictures, options,
      [&](std::size_t k) { return video_of(walked.episode(k), pictures); },
      [](std::size_t i) { return fmt::format("rgb/{:03}.jpg", i + 1); });
  std::string text = "[";
  for (std::size_t k = 0; k < walked.walks.size(); ++k) {
    text += (k > 0 ? ",\n" : "\n") + annotation(walked.walks[k], walked.episode(k), pictures);
  }
  out.write("annotations.json", text + "\n]\n");
  return report;
}

WalkReport write_navila(const ExpertWalks& walks, const fs::path& folder,
                        const WalkPictures& pictures, const ExportOptions& options) {
  const Rollouts walked = walk_as_expert("navila", walks, folder, pictures);
  const OutputFolder out = OutputFolder(folder).folder(pictures.data == "rxr" ? "RxR" : "R2R");
  const std::string& split = walks.episodes.split;
  static_cast<void>(out.folder(split));
  const WalkReport report = draw_folders(
      walked, out, pictures, options,
      [&](std::size_t k) {
        return split + "/" + detail::checked_file_name(tasks::text_of(walked.episode(k).id));
      },
      [](std::size_t i) { return fmt::format("frame_{}.jpg", i); });
  std::string text = "[";
  for (std::size_t k = 0; k < walked.walks.size(); ++k) {
    annotate(walked.walks[k], walked.episode(k), walks.simulator, text);
  }
  out.write("annotations.json", text + "\n]\n");
  return report;
}

WalkReport write_lerobot_parts(const ExpertWalks& walks, const fs::path& folder,
                               const WalkPictures& pictures, const ExportOptions& options) {
  const Rollouts walked = walk_as_expert("lerobot", walks, folder, pictures);
  const OutputFolder parts = OutputFolder(folder).folder("enfilade_export.parts");
  const auto part = [&](std::size_t k, const char* suffix) {
    return fmt::format("{:06}{}", k, suffix);
  };
  const auto is_there = [&](const std::string& name) { return file_exists(parts.path() / name); };
  const PlannedTables tables(folder, parts.path());
  const auto has_table = [&](std::size_t k) {
    // Folders of before there were plans have the tables of version 2.1.
    const auto old = fmt::format("data/chunk-{:03}/episode_{:06}.parquet", k / kChunk, k);
    return is_there(part(k, ".json")) && (tables.has(k) || file_exists(folder / old));
  };
  const WalkReport report = draw_walks(
      walked, pictures, options,
      [&](std::size_t k) { return is_there(part(k, "")) || has_table(k); },
      [&](std::size_t k, const DrawnWalk& drawn) {
        parts.write(part(k, ".rows.json"), rows_text(drawn));
        write_picture_folder(parts, part(k, ""), drawn,
                             [](std::size_t i) { return fmt::format("frame_{:06}.jpg", i); });
      });
  Json episodes = Json::array();
  for (std::size_t k = 0; k < walked.walks.size(); ++k) {
    episodes.push_back(Json{{"instruction", walked.episode(k).instruction.text},
                            {"length", walked.walks[k].actions.size()}});
  }
  parts.write("episodes.json", Json{{"split", walks.episodes.split},
                                    {"width", pictures.camera.width},
                                    {"height", pictures.camera.height},
                                    {"chunk", kChunk},
                                    {"episodes", std::move(episodes)}}
                                       .dump() +
                                   "\n");
  return report;
}

}  // namespace enfilade::exports
