// What DUET's published code computed on real graphs, if its recording lies beside the data.
#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "enfilade/core/gzip.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/features/tensor_file.h"
#include "enfilade/neural/duet/duet_network.h"
#include "enfilade/neural/duet/rollout.h"
#include "enfilade/neural/duet/training.h"

namespace enfilade::neural::duet {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kTolerance = 1e-4;  // of logits of single precision

class DuetGoldenTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto data = dataset::Dataset::from_environment();
    if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set";
    folder_ = data->folder().parent_path() / "reference" / "agents_golden";
    if (!fs::is_directory(folder_)) GTEST_SKIP() << "no recording in " << folder_;
    graphs_ = data->graphs();
    data_ = data;
  }
  json lines(const std::string& name) const {
    std::string text = read_text_file(folder_ / name);
    json list = json::array();
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t end = std::min(text.find('\n', at), text.size());
      if (end > at) list.push_back(json::parse(text.substr(at, end - at)));
      at = end + 1;
    }
    return list;
  }

  fs::path folder_;
  std::optional<dataset::Dataset> data_;
  std::shared_ptr<const graph::GraphSet> graphs_;
};

std::uint64_t name_hash(const std::string& name) {
  std::uint64_t h = 0xcbf29ce484222325;
  for (const char c : name) h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return h;
}

float synthetic(std::uint64_t hash, std::uint64_t i) {
  std::uint64_t z = hash + 0x9e3779b97f4a7c15 * (i + 1);
  z = (z ^ z >> 30U) * 0xbf58476d1ce4e5b9;
  z = (z ^ z >> 27U) * 0x94d049bb133111eb;
  z ^= z >> 31U;
  return static_cast<float>(static_cast<double>(z >> 40U) / 8388608 - 1);
}

// SYNTHETIC features: a formula of names.
class NamedSurroundings : public Surroundings {
 public:
  explicit NamedSurroundings(const dataset::Dataset& data) : data_(data) {}
  void views(const graph::NavGraph& graph, ViewpointIndex viewpoint,
             std::span<float> out) override {
    const std::uint64_t hash = name_hash(graph.scan() + "_" + graph.id(viewpoint));
    const std::size_t columns = out.size() / 36;
    for (std::size_t i = 0; i < out.size(); ++i) {
      out[i] = synthetic(hash, 65536 * (i / columns) + i % columns);
    }
  }
  std::vector<SeenObject> objects(const graph::NavGraph& graph, ViewpointIndex viewpoint) override {
    const double f = 240 / std::tan(kPi / 6);
    std::vector<SeenObject> seen;
    for (const auto& object : data_.objects().at(graph.scan(), graph.id(viewpoint))) {
      if (!object.visible()) continue;
      std::size_t largest = 0;
      const auto area = [&](std::size_t i) { return object.boxes[i][2] * object.boxes[i][3]; };
      for (std::size_t i = 1; i < object.boxes.size(); ++i) {
        if (area(i) > area(largest)) largest = i;
      }
      const auto [x, y, w, h] = object.boxes[largest];
      const std::uint32_t view = object.views[largest];
      seen.push_back({std::to_string(object.id),
                      Radians(view % 12 * (kPi / 6) + std::atan((x + w / 2.0 - 320) / f)),
                      Radians((view / 12 - 1.0) * (kPi / 6) + std::atan((240 - y - h / 2.0) / f)),
                      static_cast<double>(w), static_cast<double>(h)});
    }
    return seen;
  }
  void object(const graph::NavGraph& graph, ViewpointIndex viewpoint, std::size_t i,
              std::span<float> out) override {
    const std::string id = objects(graph, viewpoint)[i].id;
    const std::uint64_t hash = name_hash(graph.scan() + "_" + graph.id(viewpoint) + "_" + id);
    for (std::size_t c = 0; c < out.size(); ++c) out[c] = synthetic(hash, c);
  }

 private:
  const dataset::Dataset& data_;
};

at::Tensor tensor_of(const features::NamedArray& array) {
  const auto type = array.type == features::DType::kFloat32 ? at::kFloat
                    : array.type == features::DType::kInt64 ? at::kLong
                                                            : at::kByte;
  at::Tensor values = at::empty(array.shape, type);
  std::ranges::copy(array.bytes, static_cast<std::byte*>(values.data_ptr()));
  return values;
}

double largest_difference(const at::Tensor& a, const at::Tensor& b) {
  EXPECT_EQ(a.sizes(), b.sizes());
  const at::Tensor open = at::isfinite(b);
  EXPECT_TRUE(at::equal(open, at::isfinite(a)));
  const at::Tensor apart = (a - b).abs().masked_fill(open.logical_not(), 0);
  return apart.numel() == 0 ? 0 : apart.max().item<double>();
}

// One case of the parts of the network.
class UnitCase {
 public:
  UnitCase(const features::TensorFile& arrays, const json& about)
      : arrays_(arrays), about_(about), name_(about["name"]) {}

  at::Tensor array(const std::string& which) const {
    const auto* found = arrays_.find(name_ + "/" + which);
    return found == nullptr ? at::Tensor() : tensor_of(*found);
  }

  PanoramaInput panorama() const {
    return {array("in.view_img_fts"), array("in.view_lens"), array("in.obj_img_fts"),
            array("in.obj_lens"),     array("in.loc_fts"),   array("in.nav_types")};
  }

  NavigationInput navigation() const {
    NavigationInput in;
    in.nodes = array("in.gmap_img_embeds");
    in.steps = array("in.gmap_step_ids");
    in.node_positions = array("in.gmap_pos_fts");
    in.node_mask = array("in.gmap_masks").gt(0);
    in.visited = array("in.gmap_visited_masks").gt(0);
    in.distances = array("in.gmap_pair_dists");
    in.tokens = array("in.vp_img_embeds");
    in.token_positions = array("in.vp_pos_fts");
    in.token_mask = array("in.vp_masks").gt(0);
    in.choices = array("in.vp_nav_masks").gt(0);
    if (array("in.vp_obj_masks").defined()) in.objects = array("in.vp_obj_masks").gt(0);
    in.node_of_token = at::full(in.choices.sizes(), -1, at::kLong);
    for (std::size_t i = 0; i < about_["gmap_vpids"].size(); ++i) {
      const json& nodes = about_["gmap_vpids"][i];
      const json& tokens = about_["vp_cand_vpids"][i];
      for (std::size_t j = 1; j < tokens.size(); ++j) {
        const auto found = std::find(nodes.begin(), nodes.end(), tokens[j]);
        if (found == nodes.end()) continue;
        in.node_of_token[static_cast<std::int64_t>(i)][static_cast<std::int64_t>(j)] =
            static_cast<std::int64_t>(found - nodes.begin());
      }
    }
    return in;
  }

  // Of rows without their padding.
  void expect(const std::string& which, const at::Tensor& computed, const at::Tensor& mask) const {
    const at::Tensor recorded = array(which);
    ASSERT_TRUE(recorded.defined()) << which;
    EXPECT_LT(largest_difference(computed.index({mask}), recorded.index({mask})), kTolerance)
        << name_ << " " << which;
  }

 private:
  const features::TensorFile& arrays_;
  const json& about_;
  std::string name_;
};

DuetConfig config_of(const json& about, const features::TensorFile& weights) {
  DuetConfig config = infer_config(weights, 4);
  const json& options = about["options"];
  for (std::size_t i = 0; i < options.size(); ++i) {
    if (options[i] == "avg") config.fusion = Fusion::kAverage;
    if (options[i] == "NO_SPRELS") config.map_distances = false;
    if (options[i] == "--obj_feat_size")
      config.object = std::stoll(options[i + 1].get<std::string>());
  }
  return config;
}

// A network that leaves out, or adds, what a case says.
DuetNetwork network_of(const json& about, const features::TensorFile& weights,
                       const features::TensorFile& arrays) {
  const DuetConfig config = config_of(about, weights);
  DuetNetwork network(config, 1);
  const c10::NoGradGuard no_gradients;
  for (const auto& [name, values] : network.weights()) {
    const auto* found = weights.find(name);
    if (found == nullptr) {
      found = arrays.find(about["name"].get<std::string>() + "/weights." + name);
    }
    EXPECT_NE(found, nullptr) << name;
    if (found != nullptr) at::Tensor(values).copy_(tensor_of(*found));
  }
  return network;
}

TEST_F(DuetGoldenTest, PartsOfTheNetwork) {
  const json about = json::parse(read_text_file(folder_ / "duet_units.json"));
  const auto arrays = features::TensorFile::open(folder_ / "duet_units.npz");
  const c10::NoGradGuard no_gradients;
  for (const json& one : about["cases"]) {
    const auto weights = features::TensorFile::open(folder_ / one["weights"].get<std::string>());
    const DuetNetwork network = network_of(one, weights, arrays);
    const UnitCase unit(arrays, one);
    const at::Tensor words = unit.array("in.txt_masks").gt(0);
    const Tokens text = network.encode_text(unit.array("in.txt_ids"), words.sum(1));
    unit.expect("out.txt_embeds", text.values, words);
    const Tokens panorama = network.encode_panorama(unit.panorama());
    unit.expect("out.pano_embeds", panorama.values, unit.array("out.pano_masks").gt(0));
    const NavigationInput in = unit.navigation();
    const NavigationOutput out = network.navigate({unit.array("out.txt_embeds"), words}, in);
    unit.expect("out.gmap_embeds", out.nodes, in.node_mask);
    unit.expect("out.vp_embeds", out.tokens, in.token_mask);
    unit.expect("out.global_logits", out.global_logits, in.node_mask);
    unit.expect("out.local_logits", out.local_logits, in.token_mask);
    unit.expect("out.fused_logits", out.fused_logits, in.node_mask);
    if (in.objects.defined()) unit.expect("out.obj_logits", out.object_logits, in.token_mask);
  }
}

// An episode of a recording, as it is walked.
WalkEpisode episode_of(const json& record, const graph::GraphSet& graphs) {
  WalkEpisode episode;
  episode.id = record["instr_id"];
  episode.scan = graphs.at(record["scan"].get<std::string>());
  const graph::NavGraph& graph = graphs.graph(episode.scan);
  for (const json& viewpoint : record["gt_path"]) {
    episode.reference.push_back(*graph.find(viewpoint.get<std::string>()));
  }
  episode.start = episode.reference.front();
  episode.start_view = record["start_view"];
  episode.words = record["token_ids"].get<std::vector<std::int64_t>>();
  if (record.contains("gt_obj_id")) episode.object = record["gt_obj_id"];
  return episode;
}

// Compares numbers, null being minus infinity.
class Comparison {
 public:
  void numbers(const std::string& what, const json& recorded, std::span<const float> computed,
               double tolerance) {
    ASSERT_EQ(recorded.size(), computed.size()) << what;
    for (std::size_t i = 0; i < recorded.size(); ++i) {
      ++values;
      const bool open = !recorded[i].is_null();
      if (open != std::isfinite(computed[i]) ||
          (open && std::abs(recorded[i].get<double>() - double{computed[i]}) > tolerance)) {
        ADD_FAILURE() << what << "[" << i << "]: " << computed[i] << ", recorded " << recorded[i];
      }
    }
  }
  std::size_t values = 0;
};

std::vector<float> part(const at::Tensor& values, std::int64_t row, std::int64_t begin,
                        std::int64_t length) {
  const at::Tensor cut = values[row].narrow(0, begin, length).contiguous().view({-1});
  return {cut.data_ptr<float>(), cut.data_ptr<float>() + cut.numel()};
}

void compare_step(const json& record, const StepRow& row, const StepOfAll& step, std::int64_t i,
                  const graph::NavGraph& graph, Comparison& comparison) {
  const std::string where = fmt::format("step {}: ", step.step);
  EXPECT_EQ(record["viewpoint"], graph.id(row.pose.viewpoint)) << where;
  EXPECT_EQ(record["view_index"], row.pose.view) << where;
  ASSERT_EQ(record["candidates"].size(), row.candidates.size()) << where;
  for (std::size_t k = 0; k < row.candidates.size(); ++k) {
    EXPECT_EQ(record["candidates"][k][0], graph.id(row.candidates[k].viewpoint)) << where << k;
    EXPECT_EQ(record["candidates"][k][1], row.candidates[k].view) << where << k;
  }
  EXPECT_EQ(record["token_count"], row.views) << where;
  ASSERT_EQ(record["nodes"].size(), row.nodes.size()) << where;
  for (std::size_t k = 0; k < row.nodes.size(); ++k) {
    EXPECT_EQ(record["nodes"][k], graph.id(row.map->viewpoint(row.nodes[k]))) << where << k;
    EXPECT_EQ(record["visited"][k] == 1, row.map->visited(row.nodes[k])) << where << k;
  }
  const auto g = static_cast<std::int64_t>(row.nodes.size()) + 1;
  const auto c = static_cast<std::int64_t>(row.candidates.size());
  const NavigationInput& in = *step.input;
  const NavigationOutput& out = *step.output;
  json positions = json::array(), near = json::array();
  for (const json& one : record["gmap_pos_fts"]) {
    positions.insert(positions.end(), one.begin(), one.end());
  }
  for (std::int64_t k = 0; k < c; ++k) {
    const json& one = record["cand_pos_fts"][static_cast<std::size_t>(k)];
    near.insert(near.end(), record["start_pos_fts"].begin(), record["start_pos_fts"].end());
    near.insert(near.end(), one.begin(), one.end());
  }
  constexpr double kFeatures = 1e-6;  // of position features: sine and cosine of another library
  comparison.numbers(where + "gmap_pos_fts", positions, part(in.node_positions, i, 0, g),
                     kFeatures);
  comparison.numbers(where + "cand_pos_fts", near, part(in.token_positions, i, 1, c), kFeatures);
  std::vector<float> distances;
  for (std::int64_t a = 1; a < g; ++a) {
    for (std::int64_t b = a + 1; b < g; ++b) {
      distances.push_back(in.distances[i][a][b].item<float>());
    }
  }
  comparison.numbers(where + "pair_distances", record["pair_distances"], distances, 1e-5);
  comparison.numbers(where + "fuse_weight", json::array({record["fuse_weight"]}),
                     part(out.fuse_weight, i, 0, 1), kTolerance);
  comparison.numbers(where + "global_scores", record["global_scores"],
                     part(out.global_scores, i, 0, g), kTolerance);
  comparison.numbers(where + "local_scores", record["local_scores"],
                     part(out.local_scores, i, 0, c + 1), kTolerance);
  comparison.numbers(where + "global_logits", record["global_logits"],
                     part(out.global_logits, i, 0, g), kTolerance);
  comparison.numbers(where + "local_logits", record["local_logits"],
                     part(out.local_logits, i, 0, c + 1), kTolerance);
  comparison.numbers(where + "fused_logits", record["fused_logits"],
                     part(out.fused_logits, i, 0, g), kTolerance);
  if (record.contains("object_logits")) {
    const auto n = static_cast<std::int64_t>(row.objects.size());
    comparison.numbers(where + "object_logits", record["object_logits"],
                       part(out.object_logits, i, static_cast<std::int64_t>(row.views) + 1, n),
                       kTolerance);
    EXPECT_EQ(record["object_target"], row.object_label) << where;
  }
  EXPECT_EQ(record["choice"], row.choice) << where;
  EXPECT_EQ(record["expert"]["spl"], row.label) << where;
  EXPECT_EQ(record["go_to"].is_null(), !row.goes_to.has_value()) << where;
  if (row.goes_to) {
    EXPECT_EQ(record["go_to"], graph.id(*row.goes_to)) << where;
  }
}

json trajectory_of(const Walk& walk, const graph::NavGraph& graph) {
  json list = json::array();
  for (const auto& part : walk.path) {
    json ids = json::array();
    for (const ViewpointIndex viewpoint : part) ids.push_back(graph.id(viewpoint));
    list.push_back(ids);
  }
  return list;
}

TEST_F(DuetGoldenTest, GreedyEpisodes) {
  for (const std::string task : {"r2r", "reverie"}) {
    const json records = lines("duet_" + task + "_episodes.jsonl.gz");
    const auto weights = features::TensorFile::open(folder_ / ("duet_" + task + ".pt"));
    DuetConfig config = infer_config(weights, 4);
    config.max_words = 100;
    const DuetNetwork network(config, weights);
    NamedSurroundings surroundings(*data_);
    Walker walker(graphs_, surroundings);
    const c10::NoGradGuard no_gradients;
    Comparison comparison;
    std::size_t steps = 0;
    for (std::size_t begin = 1; begin < records.size(); begin += 8) {
      std::vector<WalkEpisode> batch;
      for (std::size_t k = begin; k < std::min(begin + 8, records.size()); ++k) {
        batch.push_back(episode_of(records[k], *graphs_));
      }
      WalkOptions options;
      options.expert = Expert::kShortest;
      const Rollout rollout = walker.walk(network, batch, options, [&](const StepOfAll& step) {
        for (std::size_t i = 0; i < step.rows.size(); ++i) {
          const StepRow& row = step.rows[i];
          const json& record = records[begin + row.episode];
          SCOPED_TRACE(batch[row.episode].id);
          ASSERT_LT(step.step, record["steps"].size());
          compare_step(record["steps"][step.step], row, step, static_cast<std::int64_t>(i),
                       graphs_->graph(batch[row.episode].scan), comparison);
          ++steps;
        }
      });
      for (std::size_t k = 0; k < batch.size(); ++k) {
        const json& record = records[begin + k];
        const graph::NavGraph& graph = graphs_->graph(batch[k].scan);
        const Walk& walk = rollout.walks[k];
        EXPECT_EQ(record["trajectory"], trajectory_of(walk, graph)) << batch[k].id;
        EXPECT_EQ(record["stop_node"], graph.id(walk.stop)) << batch[k].id;
        EXPECT_EQ(record["stop_probs"].size(), walk.stop_probabilities.size());
        for (const auto& [viewpoint, probability] : walk.stop_probabilities) {
          EXPECT_NEAR(record["stop_probs"][graph.id(viewpoint)].get<double>(), probability,
                      kTolerance);
        }
        if (!record.contains("pred_objid")) continue;
        const json answer = walk.object.empty() ? json() : json(walk.object);
        EXPECT_EQ(record["pred_objid"], answer) << batch[k].id;
      }
    }
    RecordProperty(task + "_values", std::to_string(comparison.values));
    RecordProperty(task + "_steps", std::to_string(steps));
    std::printf("%s: %zu steps, %zu values\n", task.c_str(), steps, comparison.values);
  }
}

// Word ids of the recording: a formula, no tokenizer.
std::vector<std::int64_t> named_words(const std::string& text) {
  constexpr std::size_t kMost = 100;
  std::vector<std::int64_t> ids{1};
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    ids.push_back(3 + static_cast<std::int64_t>(name_hash(word) % 297));
  }
  ids.push_back(2);
  ids.resize(std::min(ids.size(), kMost));
  return ids;
}

// Training's episodes are those of the recording, and two of REVERIE's own files.
class TrainingEpisodes {
 public:
  TrainingEpisodes(const json& records, const fs::path& data, const graph::GraphSet& graphs) {
    for (const json& record : records) {
      if (!record.contains("instr_id")) continue;
      WalkEpisode episode = episode_of(record, graphs);
      episodes_.emplace(episode.id, std::move(episode));
    }
    for (const char* split : {"train", "val_seen", "val_unseen"}) {
      const fs::path file = data / "reverie/v2" / fmt::format("REVERIE_{}.json", split);
      if (fs::exists(file)) add(json::parse(read_text_file(file)), graphs);
    }
  }
  std::vector<WalkEpisode> batch(const json& ids) const {
    std::vector<WalkEpisode> list;
    for (const json& id : ids) list.push_back(episodes_.at(id.get<std::string>()));
    return list;
  }

 private:
  void add(const json& items, const graph::GraphSet& graphs) {
    for (const json& item : items) {
      for (std::size_t n = 0; n < item["instructions"].size(); ++n) {
        json record = item;
        const std::string object =
            item["objId"].is_string() ? item["objId"].get<std::string>() : item["objId"].dump();
        const std::string path = item["path_id"].is_string() ? item["path_id"].get<std::string>()
                                                             : item["path_id"].dump();
        record["instr_id"] = fmt::format("{}_{}_{}", path, object, n);
        if (episodes_.contains(record["instr_id"].get<std::string>())) continue;
        record["gt_path"] = item["path"];
        record["gt_obj_id"] = object;
        record["token_ids"] = named_words(item["instructions"][n]);
        const long turns = std::lround(item["heading"].get<double>() / (kPi / 6));
        record["start_view"] = 12 + turns % 12;
        WalkEpisode episode = episode_of(record, graphs);
        episodes_.emplace(episode.id, std::move(episode));
      }
    }
  }
  std::map<std::string, WalkEpisode> episodes_;
};

WalkOptions options_of(const std::string& task, const std::string& variant, const json& feedback) {
  WalkOptions options;
  options.draw_best = true;
  options.explore = 0;
  options.three_losses = variant == "three_losses";
  options.expert = variant == "ndtw_sample" ? Expert::kLikest : Expert::kShortest;
  options.feedback = feedback == "teacher"  ? WalkFeedback::kTeacher
                     : feedback == "sample" ? WalkFeedback::kSample
                     : feedback == "argmax" ? WalkFeedback::kGreedy
                                            : WalkFeedback::kExplore;
  if (feedback == "teacher" && task == "r2r") options.expert = Expert::kReference;
  return options;
}

void compare_training_step(const json& record, const StepOfAll& step, bool teacher,
                           const std::vector<WalkEpisode>& batch, const graph::GraphSet& graphs) {
  for (const StepRow& row : step.rows) {
    const std::size_t k = row.episode;
    SCOPED_TRACE(fmt::format("{} step {}", batch[k].id, step.step));
    const graph::NavGraph& graph = graphs.graph(batch[k].scan);
    EXPECT_EQ(record["viewpoints"][k], graph.id(row.pose.viewpoint));
    EXPECT_EQ(record["fused_targets"][k], row.label);
    if (record.contains("local_targets")) {
      EXPECT_EQ(record["local_targets"][k], row.local_label);
    }
    if (record.contains("object_targets")) {
      EXPECT_EQ(record["object_targets"][k], row.object_label);
    }
    if (!teacher) {
      EXPECT_EQ(record["choices"][k], row.choice);
    }
    EXPECT_EQ(record["go_to"][k], row.goes_to ? json(graph.id(*row.goes_to)) : json());
  }
}

// Those whose gradient is zero but for rounding, and so differ from code to code.
bool is_noise(const std::string& name) {
  for (const char* end :
       {"key.bias", "in_proj_bias", "sprel_linear.bias", "global_sap_head.net.2.bias",
        "global_sap_head.net.3.bias", "og_head.net.2.bias", "og_head.net.3.bias"}) {
    if (name.ends_with(end)) return true;
  }
  return false;
}

// On an annotated path every present viewpoint but the first has one visited neighbour, so a number
// added to all local logits is added to every fused logit: no gradient either.
bool is_noise_of_imitation(const std::string& name) {
  return name.ends_with("local_sap_head.net.2.bias") || name.ends_with("local_sap_head.net.3.bias");
}

void compare_gradients(const json& recorded, const DuetNetwork& network) {
  for (const auto& [name, weight] : network.weights()) {
    if (is_noise(name) || !recorded.contains(name)) continue;
    if (recorded[name].is_null()) {
      EXPECT_FALSE(weight.grad().defined()) << name;
      continue;
    }
    ASSERT_TRUE(weight.grad().defined()) << name;
    const double length = recorded[name][0];
    const double computed = weight.grad().to(at::kDouble).norm().item<double>();
    EXPECT_NEAR(computed, length, 1e-3 * length + 1e-5) << name;
  }
}

TEST_F(DuetGoldenTest, TrainingIterations) {
  for (const std::string task : {"r2r", "reverie"}) {
    const json record =
        json::parse(read_text_file(folder_ / ("duet_" + task + "_training.json.gz")));
    const TrainingEpisodes known(lines("duet_" + task + "_episodes.jsonl.gz"), data_->folder(),
                                 *graphs_);
    const auto weights = features::TensorFile::open(folder_ / ("duet_" + task + ".pt"));
    DuetConfig config = infer_config(weights, 4);
    config.max_words = 100;
    NamedSurroundings surroundings(*data_);
    Walker walker(graphs_, surroundings);
    for (const auto& [variant, about] : record["variants"].items()) {
      SCOPED_TRACE(task + " " + variant);
      const DuetNetwork network(config, weights);
      AdamWConfig adam;
      adam.rate = record["lr"];
      AdamW optimizer(adam);
      for (const json& iteration : about["iterations"]) {
        std::vector<std::vector<WalkEpisode>> batches;
        std::vector<TrainingWalk> walks;
        const json& rollouts = iteration["rollouts"];
        for (const json& rollout : rollouts) batches.push_back(known.batch(rollout["episodes"]));
        for (std::size_t i = 0; i < batches.size(); ++i) {
          walks.push_back({batches[i], options_of(task, variant, rollouts[i]["feedback"]),
                           rollouts[i]["weight"].get<double>()});
        }
        std::size_t which = 0, last = 0;
        const TrainingStep step = accumulate(network, walker, walks, [&](const StepOfAll& walked) {
          if (walked.step < last) ++which;
          last = walked.step;
          ASSERT_LT(walked.step, rollouts[which]["steps"].size());
          compare_training_step(rollouts[which]["steps"][walked.step], walked,
                                rollouts[which]["feedback"] == "teacher", batches[which], *graphs_);
        });
        const double loss = iteration["loss"];
        EXPECT_NEAR(step.loss, loss, 1e-4 * std::abs(loss));
        if (iteration.contains("gradients") && iteration["gradients"].is_object()) {
          compare_gradients(iteration["gradients"], network);
        }
        if (variant == "imitation") {
          for (const auto& [name, weight] : network.weights()) {
            if (!is_noise_of_imitation(name)) continue;
            EXPECT_LT(weight.grad().norm().item<double>(), 1e-5) << name;
          }
        }
        const double norm = iteration["total_norm"];
        EXPECT_NEAR(optimizer.update(network), norm, 1e-3 * norm);
      }
      for (const auto& [name, weight] : network.weights()) {
        if (is_noise(name)) continue;
        if (variant == "imitation" && is_noise_of_imitation(name)) continue;
        const json& after = about["after_two_steps"][name];
        const double length = after[1];
        EXPECT_NEAR(weight.detach().to(at::kDouble).norm().item<double>(), length,
                    1e-4 * length + 1e-5)
            << name;
      }
    }
  }
}

}  // namespace
}  // namespace enfilade::neural::duet
