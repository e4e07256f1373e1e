// Checkpoints of published agents, imported and walked over a split as a user would: files of
// features, annotations with token ids, model directories. The walks are those of the published
// code.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cstdlib>
#include <map>
#include <set>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/features/hdf5_writer.h"
#include "enfilade/neural/released_weights.h"
#include "enfilade/neural/trained_agent.h"
#include "tests/conformance/agents_golden.h"
#include "tests/conformance/duet_episodes.h"
#include "tests/conformance/synthetic.h"
#include "tests/support/feature_files.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::tests {
namespace EN_UNIT {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;

constexpr std::size_t kColumns = 32;
constexpr std::size_t kViews = 36;

std::optional<AgentsFolder> recordings() {
  const char* const data = std::getenv("ENFILADE_DATA");
  if (data == nullptr) return std::nullopt;
  const fs::path folder = fs::path(data) / "../reference/agents_golden";
  if (!fs::is_directory(folder)) return std::nullopt;
  return AgentsFolder(folder, dataset::Dataset(data));
}

// The instructions of a recording, as episodes of a split, with the ids that the agent was given.
tasks::EpisodeSet episodes_of(const AgentsFolder& folder, const std::vector<json>& records,
                              tasks::Task task) {
  tasks::Annotations all;
  all.split = "recorded";
  all.file = "recorded.json";
  all.task = task;
  std::map<std::string, json> by_id;
  for (const json& record : records) {
    if (record.contains("instr_id")) by_id[record["instr_id"].get<std::string>()] = record;
  }
  for (const char* split : {"train", "val_seen", "val_unseen"}) {
    for (tasks::PathAnnotation path : folder.data().annotations(task, split).paths) {
      tasks::PathAnnotation kept = path;
      kept.instructions.clear();
      kept.details.clear();
      for (std::size_t k = 0; k < path.instructions.size(); ++k) {
        const std::string beginning = path.id.empty() ? std::to_string(path.path_id) : path.id;
        const std::string id = fmt::format("{}_{}", beginning, k);
        const auto found = by_id.find(id);
        if (found == by_id.end()) continue;
        tasks::InstructionDetails details;
        if (k < path.details.size()) details = path.details[k];
        details.id = id;
        details.tokens = found->second["token_ids"].get<std::vector<std::int32_t>>();
        // A long one is recorded as it was cut.
        constexpr std::int32_t kEnd = 2;
        if (details.tokens.back() != kEnd) details.tokens.push_back(kEnd);
        kept.instructions.push_back(path.instructions[k]);
        kept.details.push_back(details);
        by_id.erase(found);
      }
      if (!kept.instructions.empty()) all.paths.push_back(std::move(kept));
    }
  }
  EXPECT_TRUE(by_id.empty()) << by_id.size() << " instructions are in no split";
  return make_episodes(all, folder.data().graphs(), tasks::Instructions::kAll);
}

// SYNTHETIC features of all viewpoints of these episodes' buildings.
fs::path write_views(const tasks::EpisodeSet& episodes, const fs::path& file) {
  write_feature_file(
      file, kColumns, keys_of(episodes), [](const features::FeatureKey& key, std::span<float> out) {
        for (std::uint32_t view = 0; view < kViews; ++view) {
          synthetic_view(key.scan, key.viewpoint, view, out.subspan(view * kColumns, kColumns));
        }
      });
  return file;
}

// The objects of REVERIE's boxes with SYNTHETIC features, in the published form.
fs::path write_objects(const AgentsFolder& folder, const tasks::EpisodeSet& episodes,
                       const fs::path& file) {
  NamedSurroundings surroundings(folder.data());
  features::Hdf5Writer writer(file);
  std::set<std::uint32_t> scans;
  for (const tasks::ReferencePath& path : episodes.paths) {
    if (!scans.insert(path.scan.value).second) continue;
    const graph::NavGraph& graph = episodes.graphs->graph(path.scan);
    for (std::uint32_t v = 0; v < graph.size(); ++v) {
      const auto objects = surroundings.objects(graph, ViewpointIndex(v));
      if (objects.empty()) continue;
      std::vector<float> numbers(objects.size() * kColumns);
      std::vector<double> directions, sizes;
      std::vector<std::string> ids;
      for (std::size_t i = 0; i < objects.size(); ++i) {
        synthetic_object(graph.scan(), graph.id(ViewpointIndex(v)), objects[i].id,
                         std::span(numbers).subspan(i * kColumns, kColumns));
        ids.push_back(objects[i].id);
        directions.insert(directions.end(), {objects[i].heading.value, objects[i].elevation.value});
        sizes.insert(sizes.end(), {objects[i].width, objects[i].height});
      }
      const auto pairs = [&](const std::vector<double>& values) {
        return features::Hdf5Array{
            features::Hdf5Type::kFloat64, {objects.size(), 2}, std::as_bytes(std::span(values))};
      };
      writer.write(
          {graph.scan() + "_" + graph.id(ViewpointIndex(v)),
           {features::Hdf5Type::kFloat32,
            {objects.size(), kColumns},
            std::as_bytes(std::span(numbers))},
           {{"obj_ids", ids}, {"directions", pairs(directions)}, {"sizes", pairs(sizes)}}});
    }
  }
  writer.finish();
  return file;
}

// A vocabulary whose marks are those of the recorded ids.
void write_pieces(const fs::path& file) {
  std::string pieces = "[PAD]\n[CLS]\n[SEP]\n[UNK]\n";
  for (int i = 4; i < 300; ++i) pieces += fmt::format("piece{}\n", i);
  write_file_atomically(file, pieces);
}

std::vector<std::string> viewpoints_of(const tasks::Trajectory& trajectory,
                                       const graph::NavGraph& graph) {
  std::vector<std::string> ids;
  for (const auto& point : trajectory.points) {
    if (ids.empty() || ids.back() != graph.id(point.viewpoint)) {
      ids.push_back(graph.id(point.viewpoint));
    }
  }
  return ids;
}

class ReleasedAgentsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!folder_) GTEST_SKIP() << "no recorded agents beside ENFILADE_DATA";
  }

  std::unique_ptr<neural::TrainedAgent> imported(neural::ReleasedWeights weights) {
    weights.file = folder_->file(weights.file.string());
    import_weights(weights, made_.path() / "model");
    return neural::load_trained_agent(made_.path() / "model");
  }
  std::unique_ptr<neural::TrainedAgent> imported_duet(const char* file) {
    write_pieces(made_.path() / "vocab.txt");
    neural::ReleasedWeights weights{file, made_.path() / "vocab.txt"};
    weights.heads = 4;
    weights.max_words = 100;
    return imported(weights);
  }

  // Walks a recording of DUET, `batch` episodes at once, and compares.
  void compare_duet(neural::TrainedAgent& agent, const tasks::EpisodeSet& episodes,
                    const std::vector<json>& records, std::size_t batch) {
    const auto walked = agent.walk({batch, {}, {}});
    ASSERT_EQ(walked.size(), records.size() - 1) << "the first line is no episode";
    for (std::size_t i = 0; i < walked.size(); ++i) {
      const tasks::Episode& episode = episodes.episodes[i];
      const auto record = std::ranges::find_if(records, [&](const json& one) {
        return one.value("instr_id", "") == episode.instruction_id;
      });
      std::vector<std::string> recorded;
      for (const json& part : (*record)["trajectory"]) {
        for (const json& viewpoint : part) {
          const auto id = viewpoint.get<std::string>();
          if (recorded.empty() || recorded.back() != id) recorded.push_back(id);
        }
      }
      EXPECT_EQ(viewpoints_of(walked[i], episodes.graph_of(episode)), recorded)
          << episode.instruction_id;
      if (!record->contains("pred_objid")) continue;
      const json& object = (*record)["pred_objid"];
      EXPECT_EQ(walked[i].object, object.is_null() ? "" : object.get<std::string>());
    }
  }

  std::optional<AgentsFolder> folder_ = recordings();
  TemporaryFolder made_{"released_agents"};
};

TEST_F(ReleasedAgentsTest, DuetWalksAsThePublishedCode) {
  const auto records = folder_->json_lines("duet_r2r_episodes.jsonl.gz");
  const tasks::EpisodeSet episodes = episodes_of(*folder_, records, tasks::Task::kR2r);
  const auto views = features::FeatureSet::open(write_views(episodes, made_.path() / "views.hdf5"));
  const auto agent = imported_duet("duet_r2r.pt");
  agent->enter(episodes, &views);
  compare_duet(*agent, episodes, records, 8);
  compare_duet(*agent, episodes, records, 3);
}

TEST_F(ReleasedAgentsTest, DuetNamesReveriesObjectsAsThePublishedCode) {
  const auto records = folder_->json_lines("duet_reverie_episodes.jsonl.gz");
  const tasks::EpisodeSet episodes = episodes_of(*folder_, records, tasks::Task::kReverie);
  const auto views = features::FeatureSet::open(write_views(episodes, made_.path() / "views.hdf5"));
  const auto agent = imported_duet("duet_reverie.pt");
  EXPECT_THAT(refusal<ArgumentError>([&] { agent->enter(episodes, &views); }),
              HasSubstr("needs their features (enfilade evaluate --objects FILE)"));
  agent->set_objects(std::make_shared<const features::ObjectSet>(
      features::ObjectSet::open(write_objects(*folder_, episodes, made_.path() / "objects.hdf5"))));
  agent->enter(episodes, &views);
  compare_duet(*agent, episodes, records, 8);
}

TEST_F(ReleasedAgentsTest, EnvDropsListenerWalksAsThePublishedCode) {
  const auto records = folder_->json_lines("envdrop_episodes.jsonl.gz");
  const tasks::EpisodeSet episodes = episodes_of(*folder_, records, tasks::Task::kR2r);
  const auto views = features::FeatureSet::open(write_views(episodes, made_.path() / "views.hdf5"));
  neural::ReleasedWeights weights{"envdrop.pt", folder_->data().folder() / "vocab/train_vocab.txt"};
  weights.max_steps = 20;
  const auto agent = imported(weights);
  agent->enter(episodes, &views);
  const auto walked = agent->walk({1, {}, {}});  // as padding has a part in the published code
  for (std::size_t i = 0; i < walked.size(); ++i) {
    const tasks::Episode& episode = episodes.episodes[i];
    const auto record = std::ranges::find_if(records, [&](const json& one) {
      return one.value("instr_id", "") == episode.instruction_id;
    });
    std::vector<std::string> alone;
    for (const auto& viewpoint : (*record)["alone"]["viewpoints"].get<std::vector<std::string>>()) {
      if (alone.empty() || alone.back() != viewpoint) alone.push_back(viewpoint);
    }
    std::vector<std::string> ours = viewpoints_of(walked[i], episodes.graph_of(episode));
    // Recorded is where it chose; a last move, at the limit, leads to where it chooses no more.
    if (!(*record)["stopped"].get<bool>()) ours.pop_back();
    EXPECT_EQ(ours, alone) << episode.instruction_id;
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::tests
