/// \file  A data set and a network small enough to train within a test.
#pragma once
#include <gtest/gtest.h>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "enfilade/core/file.h"
#include "enfilade/core/rng.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/neural/train.h"
#include "tests/support/feature_files.h"
#include "tests/support/small_homes.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::tests {

/// What an interrupted training throws, in place of the signal that a process would get.
struct Stop : std::runtime_error {
  Stop() : std::runtime_error("stopped") {}
};

/// The bytes of a model's weights.
inline std::string weights_of(const std::filesystem::path& folder) {
  return read_file(models::ModelFiles{folder}.weights());
}
/// The lines of its log, without starts and times.
inline std::vector<nlohmann::json> log_of(const std::filesystem::path& folder) {
  std::vector<nlohmann::json> lines;
  const std::string text = read_file(models::ModelFiles{folder}.log());
  for (std::size_t at = 0; at < text.size(); at = text.find('\n', at) + 1) {
    lines.push_back(nlohmann::json::parse(text.substr(at, text.find('\n', at) - at)));
    for (const char* own : {"time", "seconds"}) lines.back().erase(own);
  }
  std::erase_if(lines, [](const nlohmann::json& line) { return line["type"] == "start"; });
  return lines;
}

/// Three model homes without pictures, with paths and instructions, and random features of their
/// views.
class SmallTraining {
 public:
  static constexpr std::size_t kDimensions = 5;

  SmallTraining() {
    write_small_homes(data());
    write_features(features(), kDimensions);
  }

  std::filesystem::path data() const { return folder_.path() / "data"; }
  std::filesystem::path features() const { return folder_.path() / "features.safetensors"; }
  /// A folder, not there yet, to train into.
  std::filesystem::path model(const std::string& name) const { return folder_.path() / name; }
  dataset::Dataset root() const { return dataset::Dataset(data()); }

  void write_features(const std::filesystem::path& file, std::size_t dimensions) const {
    using namespace features;  // NOLINT(google-build-using-namespace): names of one folder
    const auto graphs = root().graphs();
    std::vector<FeatureKey> keys;
    for (const std::string& scan : graphs->scans()) {
      const graph::NavGraph& graph = graphs->graph(scan);
      for (std::size_t i = 0; i < graph.size(); ++i) {
        keys.push_back({scan, graph.id(ViewpointIndex(i))});
      }
    }
    Rng rng(1);
    write_feature_file(file, dimensions, keys, [&](const FeatureKey&, std::span<float> views) {
      for (float& value : views) value = static_cast<float>(rng.uniform());
    });
  }

  /// Learns nothing, but goes through everything: 12 iterations, evaluation at 6 and 12,
  /// checkpoints at 5, 10 and 12.
  static models::TrainConfig config(models::AgentKind agent = models::AgentKind::kSeq2Seq) {
    models::TrainConfig config = models::recipe(agent);
    config.network.max_words = 30;
    config.network.word_embedding = 6;
    config.network.hidden = 8;
    config.network.action_embedding = 3;
    config.panoramic.word_embedding = 6;
    config.panoramic.action_embedding = 3;
    config.panoramic.hidden = 8;
    config.panoramic.angle = 4;
    config.panoramic.subout = models::Subout::kOwnMax;
    config.duet = models::duet_preset("duet-s");
    config.duet.hidden = 8;
    config.duet.heads = 2;
    config.duet.feed_forward = config.duet.panorama_feed_forward = 12;
    config.duet.text_layers = config.duet.panorama_layers = config.duet.cross_layers = 1;
    config.speaker.word_embedding = 6;
    config.speaker.hidden = 8;
    config.speaker.angle = 4;
    config.iterations = 12;
    config.batch_size = 16;
    config.max_steps = 6;
    config.adam.learning_rate = 0.01;  // so that weights differ visibly after a few updates
    config.evaluate_every = 6;
    config.checkpoint_every = 5;
    return config;
  }

  bool train(const std::filesystem::path& folder, const models::TrainConfig& config,
             const std::optional<std::filesystem::path>& from = {}) const {
    return neural::train(config, load(config), folder, {}, {}, from);
  }
  /// Expects that Stop comes after so many iterations.
  void train_until(const std::filesystem::path& folder, const models::TrainConfig& config,
                   std::uint64_t stop,
                   const std::optional<std::filesystem::path>& from = {}) const {
    neural::TrainingListener listener;
    listener.iteration = [stop](const neural::TrainingProgress& progress) {
      if (progress.iteration == stop) throw Stop();
    };
    EXPECT_THROW(neural::train(config, load(config), folder, {}, listener, from), Stop);
  }

  neural::TrainingData load(const models::TrainConfig& config) const {
    return neural::load_training_data(root(), config, features());
  }

 private:
  TemporaryFolder folder_{"small_training"};
};

}  // namespace enfilade::tests
