#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/file.h"
#include "enfilade/exports/detail/parquet_file.h"
#include "enfilade/exports/detail/walk_frames.h"
#include "enfilade/exports/expert_walks.h"

namespace enfilade::exports {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kStepsASecond = 5;
constexpr std::size_t kChunk = 1000;  // episodes in a folder
constexpr const char* kPictures = "observation.images.rgb";
constexpr std::size_t kStateColumns = 4;

// What is known of all walks before a picture is drawn.
struct Plan {
  std::vector<std::size_t> task;        // of each walk, by its instruction
  std::vector<std::string> tasks;       // different instructions, in the order of the walks
  std::vector<std::int64_t> first_row;  // of each walk in the whole set
  std::int64_t rows = 0;
};

Plan plan_of(const detail::Walked& walked, const tasks::ContinuousEpisodes& episodes) {
  Plan plan;
  std::map<std::string, std::size_t> known;
  for (const tasks::ContinuousResult& walk : walked.walks) {
    const std::string& text = episodes.episodes.at(walk.episode).instruction.text;
    const auto [it, is_new] = known.emplace(text, plan.tasks.size());
    if (is_new) plan.tasks.push_back(text);
    plan.task.push_back(it->second);
    plan.first_row.push_back(plan.rows);
    plan.rows += static_cast<std::int64_t>(walk.actions.size());
  }
  return plan;
}

fs::path file_of(std::size_t walk) {
  return fmt::format("data/chunk-{:03}/episode_{:06}.parquet", walk / kChunk, walk);
}

// How `datasets` is to take the columns; without it, a picture would be a pair of texts.
std::string huggingface_features() {
  const auto value = [](const char* type) { return Json{{"dtype", type}, {"_type", "Value"}}; };
  const Json features{
      {kPictures, {{"_type", "Image"}}},
      {"observation.state", {{"feature", value("float32")}, {"length", -1}, {"_type", "Sequence"}}},
      {"action", value("int64")},
      {"timestamp", value("float32")},
      {"frame_index", value("int64")},
      {"episode_index", value("int64")},
      {"index", value("int64")},
      {"task_index", value("int64")}};
  return Json{{"info", {{"features", features}}}}.dump();
}

// The same for LeRobot's own reader.
Json lerobot_features(const Camera& camera) {
  const auto number = [](const char* type) {
    return Json{{"dtype", type}, {"shape", {1}}, {"names", nullptr}};
  };
  return Json{
      {kPictures,
       {{"dtype", "image"},
        {"shape", {camera.height, camera.width, 3}},
        {"names", {"height", "width", "channel"}}}},
      {"observation.state",
       {{"dtype", "float32"}, {"shape", {kStateColumns}}, {"names", {"x", "y", "z", "heading"}}}},
      {"action", {{"dtype", "int64"}, {"shape", {1}}, {"names", {"action"}}}},
      {"timestamp", number("float32")},
      {"frame_index", number("int64")},
      {"episode_index", number("int64")},
      {"index", number("int64")},
      {"task_index", number("int64")}};
}

// The columns of a trajectory except its pictures; statistics are made of them, too.
std::vector<detail::ParquetColumn> numbers_of(const tasks::ContinuousResult& walk,
                                              std::size_t index, const Plan& plan) {
  const std::size_t rows = walk.actions.size();
  detail::FloatLists state{kStateColumns, {}};
  std::vector<std::int64_t> actions, frames, all;
  std::vector<float> times;
  for (std::size_t k = 0; k < rows; ++k) {
    const Vec3f& p = walk.positions[k];
    state.values.insert(state.values.end(),
                        {p.x, p.y, p.z, static_cast<float>(walk.headings[k].value)});
    actions.push_back(walk.actions[k]);
    times.push_back(static_cast<float>(k) / kStepsASecond);
    frames.push_back(static_cast<std::int64_t>(k));
    all.push_back(plan.first_row[index] + static_cast<std::int64_t>(k));
  }
  const auto same = [&](std::size_t value) {
    return std::vector<std::int64_t>(rows, static_cast<std::int64_t>(value));
  };
  return {{"observation.state", std::move(state)}, {"action", std::move(actions)},
          {"timestamp", std::move(times)},         {"frame_index", std::move(frames)},
          {"episode_index", same(index)},          {"index", std::move(all)},
          {"task_index", same(plan.task[index])}};
}

// Least, most, mean and deviation of each number of a row.
template <class T>
Json statistics(const std::vector<T>& values, std::size_t columns) {
  std::vector<double> least(columns, INFINITY), most(columns, -INFINITY), mean(columns),
      deviation(columns);
  const auto rows = static_cast<double>(values.size() / columns);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto value = static_cast<double>(values[i]);
    least[i % columns] = std::min(least[i % columns], value);
    most[i % columns] = std::max(most[i % columns], value);
    mean[i % columns] += value / rows;
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double off = static_cast<double>(values[i]) - mean[i % columns];
    deviation[i % columns] += off * off / rows;
  }
  for (double& d : deviation) d = std::sqrt(d);
  return Json{{"min", least},
              {"max", most},
              {"mean", mean},
              {"std", deviation},
              {"count", {values.size() / columns}}};
}

Json statistics(const detail::PixelStatistics& pixels, std::size_t pictures) {
  const auto of = [](const std::array<double, 3>& v) {
    return Json{{{v[0]}}, {{v[1]}}, {{v[2]}}};  // (3, 1, 1)
  };
  return Json{{"min", of(pixels.least)},
              {"max", of(pixels.most)},
              {"mean", of(pixels.mean)},
              {"std", of(pixels.deviation)},
              {"count", {pictures}}};
}

std::string statistics_line(std::size_t index, const std::vector<detail::ParquetColumn>& columns,
                            const detail::DrawnWalk& drawn) {
  Json all;
  all[kPictures] = statistics(drawn.pixels, drawn.pictures.size());
  for (const detail::ParquetColumn& column : columns) {
    if (const auto* lists = std::get_if<detail::FloatLists>(&column.cells)) {
      all[column.name] = statistics(lists->values, lists->columns);
    } else if (const auto* floats = std::get_if<std::vector<float>>(&column.cells)) {
      all[column.name] = statistics(*floats, 1);
    } else {
      all[column.name] = statistics(std::get<std::vector<std::int64_t>>(column.cells), 1);
    }
  }
  return Json{{"episode_index", index}, {"stats", std::move(all)}}.dump() + "\n";
}

void write_meta(const fs::path& meta, const detail::Walked& walked, const Plan& plan,
                const std::string& split, const Camera& camera) {
  std::string episodes, tasks;
  for (std::size_t k = 0; k < walked.walks.size(); ++k) {
    episodes += Json{{"episode_index", k},
                     {"tasks", {plan.tasks[plan.task[k]]}},
                     {"length", walked.walks[k].actions.size()}}
                    .dump() +
                "\n";
  }
  for (std::size_t k = 0; k < plan.tasks.size(); ++k) {
    tasks += Json{{"task_index", k}, {"task", plan.tasks[k]}}.dump() + "\n";
  }
  const std::size_t count = walked.walks.size();
  Json info{{"codebase_version", "v2.1"},
            {"robot_type", "vln-ce"},
            {"total_episodes", count},
            {"total_frames", plan.rows},
            {"total_tasks", plan.tasks.size()},
            {"total_videos", 0},
            {"total_chunks", (count + kChunk - 1) / kChunk},
            {"chunks_size", kChunk},
            {"fps", kStepsASecond},
            {"splits", {{split, fmt::format("0:{}", count)}}},
            {"data_path", "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet"},
            {"video_path", nullptr},
            {"features", lerobot_features(camera)}};
  write_file_atomically(meta / "episodes.jsonl", episodes);
  write_file_atomically(meta / "tasks.jsonl", tasks);
  write_file_atomically(meta / "info.json", info.dump(2) + "\n");
}

}  // namespace

WalkReport write_lerobot(const ExpertWalks& walks, const fs::path& folder,
                         const WalkPictures& pictures, const ExportOptions& options) {
  const detail::Walked walked = detail::walk_as_expert("lerobot", walks, folder, pictures);
  const Plan plan = plan_of(walked, walks.episodes);
  const std::string features = huggingface_features();
  // A walk's statistics, until all are there; written before its table, which says that it is done.
  const fs::path parts = folder / "enfilade_export.parts";
  const auto line_of = [&](std::size_t k) { return parts / fmt::format("{:06}.json", k); };
  make_folder(folder / "meta");
  make_folder(parts);
  for (std::size_t k = 0; k < walked.walks.size(); k += kChunk) {
    make_folder((folder / file_of(k)).parent_path());
  }
  const auto write = [&](std::size_t k, const detail::DrawnWalk& drawn) {
    std::vector<detail::ParquetColumn> columns = numbers_of(drawn.walk, k, plan);
    write_file_atomically(line_of(k), statistics_line(k, columns, drawn));
    detail::PictureCells cells{drawn.pictures, {}};
    for (std::size_t i = 0; i < drawn.pictures.size(); ++i) {
      cells.paths.push_back(fmt::format("frame_{:06}.jpg", i));
    }
    columns.insert(columns.begin(), {kPictures, std::move(cells)});
    write_file_atomically(folder / file_of(k),
                          detail::parquet_file(columns, {{"huggingface", features}}));
  };
  const WalkReport report = detail::draw_walks(
      walked, walks, pictures, options,
      {[&](std::size_t k) { return file_exists(folder / file_of(k)) && file_exists(line_of(k)); },
       write});
  std::string lines;
  for (std::size_t k = 0; k < walked.walks.size(); ++k) lines += read_file(line_of(k));
  write_file_atomically(folder / "meta" / "episodes_stats.jsonl", lines);
  write_meta(folder / "meta", walked, plan, walks.episodes.split, pictures.camera);
  return report;
}

}  // namespace enfilade::exports
