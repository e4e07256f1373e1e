#include "enfilade/neural/released_weights.h"

#include <ATen/core/Tensor.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cstdlib>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/neural/duet/duet_network.h"
#include "enfilade/neural/panoramic/panoramic_network.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::neural {
namespace EN_UNIT {

namespace fs = std::filesystem;
using features::NamedArray;
using models::AgentKind;
using models::TextKind;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using tests::refusal;

constexpr std::int64_t kPieces = 9;

models::DuetConfig tiny_duet() {
  models::DuetConfig config;
  config.hidden = 8;
  config.heads = 2;
  config.feed_forward = config.panorama_feed_forward = 12;
  config.text_layers = config.panorama_layers = config.cross_layers = 1;
  config.vocabulary = kPieces;
  config.positions = config.max_words = 16;
  config.image = 5;
  config.object = 3;
  config.steps = 20;
  return config;
}

models::PanoramicConfig tiny_listener() {
  models::PanoramicConfig config;
  config.vocabulary = 6;
  config.word_embedding = 3;
  config.action_embedding = 2;
  config.hidden = 4;
  config.image = 5;
  config.angle = 4;
  return config;
}

class ReleasedWeightsTest : public ::testing::Test {
 protected:
  ReleasedWeightsTest() {
    write_file_atomically(path("vocab.txt"),
                          "[PAD]\n[UNK]\n[CLS]\n[SEP]\n[MASK]\ngo\nleft\n##s\n.\n");
    write_file_atomically(path("words.txt"), "<PAD>\n<UNK>\n<EOS>\ngo\nleft\n");
    features::write_safetensors(path("duet.safetensors"), core::as_arrays(duet_.weights()));
    released_.file = path("duet.safetensors");
    released_.vocabulary = path("vocab.txt");
    released_.heads = 2;
  }

  fs::path path(const char* name) const { return folder_.path() / name; }

  // The arrays of the tiny DUET, changed, as a file.
  template <class Change>
  void rewrite(const Change& change) {
    std::vector<NamedArray> arrays = core::as_arrays(duet_.weights());
    change(arrays);
    features::write_safetensors(path("changed.safetensors"), arrays);
    released_.file = path("changed.safetensors");
  }
  // A name of the agent's as DUET's pretraining has it.
  static std::string in_pretraining(const std::string& name) {
    const std::string part = name.substr(std::string("vln_bert.").size());
    const bool is_head = part.find("_head.") != std::string::npos || part.starts_with("sap_");
    return is_head ? part : "bert." + part;
  }
  std::string refused() {
    return refusal([&] { import_weights(released_, path("model")); });
  }

  tests::TemporaryFolder folder_{"released"};
  duet::DuetNetwork duet_{tiny_duet(), 3};
  ReleasedWeights released_;
};

TEST_F(ReleasedWeightsTest, DuetBecomesAModelDirectory) {
  const ImportedWeights found = import_weights(released_, path("model"));
  EXPECT_EQ(found.arrays, duet_.weights().size());
  EXPECT_EQ(found.vocabulary, path("model/pieces.txt"));
  const models::ModelFiles files{path("model")};
  const models::TrainConfig training = models::load_model_config(files.config()).training;
  EXPECT_EQ(training.agent, AgentKind::kDuet);
  EXPECT_EQ(training.text, TextKind::kWordPieces);
  EXPECT_EQ(training.network.features, 5U);
  EXPECT_EQ(training.network.max_words, 16U) << "no more places";
  EXPECT_EQ(training.max_steps, 15U);
  const models::DuetConfig sizes = duet_sizes(training);
  EXPECT_EQ(sizes.vocabulary, kPieces);
  EXPECT_EQ(sizes.object, 3);
  EXPECT_EQ(sizes.heads, 2);
  const models::InstructionWords words = load_instruction_words(files, training);
  EXPECT_THAT(words.encode("Go lefts.", 9), ElementsAre(2, 5, 6, 7, 8, 3));
  const models::StateFile state = models::open_state(files.weights());
  const duet::DuetNetwork again(sizes, state.file);
  EXPECT_EQ(core::hash_of(again.weights()), core::hash_of(duet_.weights()));
}

TEST_F(ReleasedWeightsTest, NamesOfPretrainingAreThoseOfTheAgent) {
  std::vector<std::string> names;
  std::vector<float> numbers(4);
  rewrite([&](std::vector<NamedArray>& arrays) {
    for (NamedArray& array : arrays) {
      // As data parallelism, torch.compile() and Lightning put one around the other.
      array.name = "module._orig_mod.model." + in_pretraining(array.name);
    }
    const auto extra = [&](const char* name) {
      arrays.push_back({name, features::DType::kFloat32, {4}, std::as_bytes(std::span(numbers))});
    };
    extra("module.mlm_head.predictions.bias");
    extra("mlm_head.predictions.bias");  // no array of the agent, so it may be there twice
    extra("module.bert.local_encoder.encoder.x_layers.0.lang_inter.dense.bias");
  });
  const ImportedWeights found = import_weights(released_, path("model"));
  EXPECT_THAT(found.family, HasSubstr("pretraining"));
  EXPECT_THAT(found.left_out, ElementsAre("bert: 1 arrays", "mlm_head: 2 arrays"));
  const models::StateFile state = models::open_state(path("model/weights.safetensors"));
  const duet::DuetNetwork again(tiny_duet(), state.file);
  EXPECT_EQ(core::hash_of(again.weights()), core::hash_of(duet_.weights()));
}

TEST_F(ReleasedWeightsTest, FaultsOfAPretrainedFileNameItAndTheirReason) {
  rewrite([](std::vector<NamedArray>& arrays) {
    for (NamedArray& array : arrays) array.name = in_pretraining(array.name);
    arrays.push_back(arrays.front());
    arrays.back().name = "module." + arrays.front().name;
  });
  EXPECT_THAT(refused(), AllOf(HasSubstr("changed.safetensors"), HasSubstr("repeated-array")));
  rewrite([](std::vector<NamedArray>& arrays) {
    for (NamedArray& array : arrays) {
      array.name = in_pretraining(array.name);
      if (array.name != "bert.embeddings.position_embeddings.weight") continue;
      array.type = features::DType::kFloat16;
      array.bytes = array.bytes.first(array.bytes.size() / 2);
    }
  });
  std::string file = read_file(released_.file);
  file[file.find("\"F16\"") + 1] = 'I';
  write_file_atomically(released_.file, file);
  EXPECT_THAT(refused(), AllOf(HasSubstr("changed.safetensors"), HasSubstr("I16"),
                               HasSubstr("position_embeddings"), HasSubstr("missing-array")));
}

TEST_F(ReleasedWeightsTest, EnvDropsListenerReadsWords) {
  const panoramic::PanoramicNetwork listener(tiny_listener(), 4);
  features::write_safetensors(path("listener.safetensors"), core::as_arrays(listener.weights()));
  released_.file = path("listener.safetensors");
  released_.vocabulary = path("words.txt");
  released_.subout = models::Subout::kTanh;
  released_.max_steps = 20;
  const ImportedWeights found = import_weights(released_, path("model"));
  EXPECT_EQ(found.config.training.agent, AgentKind::kPanoramic);
  const models::ModelFiles files{path("model")};
  const models::TrainConfig training = models::load_model_config(files.config()).training;
  EXPECT_EQ(training.max_steps, 20U);
  EXPECT_EQ(panoramic_sizes(training).vocabulary, 6U);
  EXPECT_EQ(panoramic_sizes(training).subout, models::Subout::kTanh);
  EXPECT_EQ(load_instruction_words(files, training).begin(), 5) << "<BOS> behind the words";
  const panoramic::PanoramicNetwork again(panoramic_sizes(training),
                                          models::open_state(files.weights()).file);
  EXPECT_EQ(core::hash_of(again.weights()), core::hash_of(listener.weights()));
}

TEST_F(ReleasedWeightsTest, OtherNetworksAreRefusedWithTheirNames) {
  rewrite([](std::vector<NamedArray>& arrays) {
    for (NamedArray& array : arrays) array.name = "hamt." + array.name;
  });
  EXPECT_THAT(refused(), AllOf(HasSubstr("the names of no agent that is known"),
                               HasSubstr("\"hamt.vln_bert.embeddings.LayerNorm.bias\""),
                               HasSubstr("EnvDrop")));
  rewrite([](std::vector<NamedArray>& arrays) {
    for (NamedArray& array : arrays) {
      const std::string name = array.name;
      const std::size_t at = name.find("img_embeddings.pano_encoder");
      if (at != std::string::npos) array.name = "vln_bert.bev_encoder" + name.substr(at);
    }
  });
  EXPECT_THAT(refused(), AllOf(HasSubstr("not the network of DUET"), HasSubstr("surplus-array"),
                               HasSubstr("vln_bert.bev_encoder")))
      << "a descendant with arrays of its own";
  EXPECT_FALSE(fs::exists(path("model"))) << "nothing is left behind";
  released_.agent = AgentKind::kPanoramic;
  released_.file = path("duet.safetensors");
  EXPECT_THAT(refused(), HasSubstr("weights of the agent duet, not of panoramic"));
}

TEST_F(ReleasedWeightsTest, AMissingArrayIsNamed) {
  rewrite([](std::vector<NamedArray>& arrays) {
    std::erase_if(arrays, [](const NamedArray& array) {
      return array.name == "vln_bert.local_sap_head.net.3.bias";
    });
  });
  EXPECT_THAT(refused(),
              AllOf(HasSubstr("vln_bert.local_sap_head.net.3.bias"), HasSubstr("missing-array")));
}

TEST_F(ReleasedWeightsTest, VocabulariesOfAnotherSizeAreRefused) {
  write_file_atomically(path("short.txt"), "[PAD]\n[UNK]\n[CLS]\n[SEP]\ngo\n");
  released_.vocabulary = path("short.txt");
  EXPECT_THAT(refused(), AllOf(HasSubstr("short.txt: 5 pieces"), HasSubstr("has 9 rows")));
  released_.vocabulary = path("words.txt");
  EXPECT_THAT(refused(), HasSubstr("words.txt: 5 words (and 2 of marks)"));
  released_.vocabulary.clear();
  EXPECT_THAT(refused(), AllOf(HasSubstr("its table of words has 9 rows"),
                               HasSubstr("give --vocabulary FILE")));
  released_.vocabulary = path("none.txt");
  EXPECT_THAT(refused(), HasSubstr("none.txt: cannot open"));
  EXPECT_FALSE(fs::exists(path("model")));
}

TEST_F(ReleasedWeightsTest, WhereSomethingIsNothingIsWritten) {
  fs::create_directory(path("model"));
  write_file_atomically(path("model/notes.txt"), "mine");
  EXPECT_THAT(refused(), HasSubstr("is there already and not an empty folder"));
  fs::remove(path("model/notes.txt"));
  EXPECT_EQ(import_weights(released_, path("model")).config.training.agent, AgentKind::kDuet);
  released_.max_words = 17;
  EXPECT_THAT(refusal([&] { import_weights(released_, path("other")); }),
              HasSubstr("17, but the network has places for 16"));
  EXPECT_FALSE(fs::exists(path("other")));
}

// What published code saved, with an optimizer's state and a critic.
TEST_F(ReleasedWeightsTest, CheckpointsOfThePublishedCodeAreRead) {
  const char* const data = std::getenv("ENFILADE_DATA");
  if (data == nullptr) GTEST_SKIP() << "ENFILADE_DATA is not set";
  const fs::path recorded = fs::path(data) / "../reference/agents_golden";
  if (!fs::exists(recorded)) GTEST_SKIP() << "no recorded agents beside ENFILADE_DATA";
  std::string pieces = "[PAD]\n[CLS]\n[SEP]\n[UNK]\n";
  for (int i = 4; i < 300; ++i) pieces += fmt::format("piece{}\n", i);
  write_file_atomically(path("vocab.txt"), pieces);
  released_.file = recorded / "duet_reader.pt";
  const ImportedWeights reader = import_weights(released_, path("reader"));
  EXPECT_EQ(reader.iteration, 7U) << "epoch 8";
  EXPECT_THAT(reader.left_out,
              ElementsAre("critic.optimizer", "vln_bert.optimizer", "critic: 4 arrays"));
  EXPECT_EQ(reader.config.training.duet.hidden, 16);

  released_.file = recorded / "envdrop.pt";
  released_.vocabulary = fs::path(data) / "vocab/train_vocab.txt";
  const ImportedWeights listener = import_weights(released_, path("listener"));
  EXPECT_EQ(listener.config.training.network.vocabulary, 991U);
  EXPECT_EQ(listener.config.training.network.features, 32U);
  EXPECT_EQ(listener.config.training.panoramic.hidden, 64U);
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural
