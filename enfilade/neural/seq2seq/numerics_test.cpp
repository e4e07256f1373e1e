// The network against an independent implementation in Python: tests/python/seq2seq_reference.py.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <array>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/neural/seq2seq/kernels.h"
#include "enfilade/neural/seq2seq/seq2seq.h"
#include "tests/support/scripted_environment.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::neural::seq2seq {
namespace EN_UNIT {

using tests::made_tokens;
using tests::Script;
using tests::ScriptedEnvironment;
using tests::TemporaryFolder;

constexpr std::size_t kEpisodes = 10, kSteps = 8, kUpdates = 3;

// Of the paper's shape, but small: Python's double precision is to be done in a second.
models::NetworkConfig config() {
  models::NetworkConfig result;
  result.vocabulary = 60;
  result.max_words = 20;
  result.word_embedding = 40;
  result.hidden = 72;
  result.action_embedding = 9;
  result.features = 130;
  return result;
}

/// Arrays for the script, kept until they are written.
class Arrays {
 public:
  template <class T>
  void add(std::string name, features::DType type, std::vector<std::int64_t> shape,
           const std::vector<T>& values) {
    std::vector<std::byte> bytes(values.size() * sizeof(T));
    std::memcpy(bytes.data(), values.data(), bytes.size());
    storage_.push_back(std::move(bytes));
    arrays_.push_back({std::move(name), type, std::move(shape), storage_.back()});
  }
  void add(const std::string& prefix, Network::State state) {
    for (features::NamedArray& array : state.arrays) {
      array.name = prefix + array.name;
      arrays_.push_back(std::move(array));
    }
    for (auto& bytes : state.storage) storage_.push_back(std::move(bytes));
  }
  void write(const std::filesystem::path& file) const {
    features::write_safetensors(file, arrays_);
  }

 private:
  std::vector<features::NamedArray> arrays_;
  std::vector<std::vector<std::byte>> storage_;
};

std::int64_t as_signed(std::size_t n) { return static_cast<std::int64_t>(n); }

// What a rollout multiplies with: 0 or the scale; ones without dropout.
std::vector<float> factors(const RolloutDropout& dropout, DropoutSite site,
                           const std::vector<MaskRow>& rows, std::size_t width) {
  std::vector<float> result(rows.size() * width, 1);
  std::vector<std::uint64_t> kept(mask_words(width));
  for (std::size_t i = 0; i < rows.size() && dropout.on(); ++i) {
    draw_mask(dropout, site, rows[i], width, kept);
    for (std::size_t k = 0; k < width; ++k) {
      result[i * width + k] = (kept[k / 64] >> (k % 64) & 1U) != 0 ? dropout.scale() : 0;
    }
  }
  return result;
}

std::vector<MaskRow> by_row(std::size_t words) {
  std::vector<MaskRow> rows;
  for (std::uint32_t r = 0; r < kEpisodes; ++r) {
    for (std::uint32_t p = 0; p < words; ++p) rows.push_back({p, r});
  }
  return rows;
}

std::vector<MaskRow> by_step() {
  std::vector<MaskRow> rows;
  for (std::uint32_t t = 0; t < kSteps; ++t) {
    for (std::uint32_t r = 0; r < kEpisodes; ++r) rows.push_back({t, r});
  }
  return rows;
}

void add_masks(Arrays& arrays, const RolloutDropout& dropout, std::size_t words) {
  const models::NetworkConfig sizes = config();
  const auto add = [&](const char* name, DropoutSite site, bool of_words, std::size_t width) {
    const auto values = factors(dropout, site, of_words ? by_row(words) : by_step(), width);
    arrays.add(name, features::DType::kFloat32,
               {as_signed(of_words ? kEpisodes : kSteps), as_signed(of_words ? words : kEpisodes),
                as_signed(width)},
               values);
  };
  add("mask.words", DropoutSite::kWords, true, sizes.word_embedding);
  add("mask.context", DropoutSite::kContext, true, sizes.hidden);
  add("mask.actions", DropoutSite::kActions, false, sizes.action_embedding);
  add("mask.features", DropoutSite::kFeatures, false, sizes.features);
  add("mask.attention", DropoutSite::kAttention, false, sizes.hidden);
}

std::size_t longest(const std::vector<std::uint32_t>& tokens) {
  std::size_t most = 0;
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    if (tokens[i] != 0) most = std::max(most, i % config().max_words + 1);
  }
  return most;
}

// The rollout, what it was fed, and what came of it.
void fill(Arrays& arrays, models::Feedback feedback, bool dropout) {
  const auto n = as_signed(kEpisodes), steps = as_signed(kSteps);
  const std::vector<std::uint32_t> tokens =
      made_tokens(kEpisodes, config().max_words, config().vocabulary, 2);
  ScriptedEnvironment environment(Script{kEpisodes, config().features, kSteps, true, true}, 4);
  Network network(config(), 5);
  RolloutOptions options;
  options.feedback = feedback;
  options.max_steps = kSteps;
  options.dropout = dropout;
  options.seed = 6;
  arrays.add("", network.weights());
  for (std::size_t i = 0; i < kUpdates; ++i) {
    options.stream = i;
    environment.begin();
    const double loss =
        network.rollout_with_gradients({tokens, kEpisodes}, environment, options).loss;
    if (i == 0) {
      arrays.add("loss", features::DType::kFloat64, {}, std::vector<double>{loss});
      arrays.add("gradient.", network.gradients());
      std::vector<std::int32_t> inputs(kEpisodes, kStartInput);
      inputs.insert(inputs.end(), environment.actions.begin(),
                    environment.actions.end() - as_signed(kEpisodes));
      arrays.add("inputs", features::DType::kInt32, {steps, n}, inputs);
    }
    arrays.add(fmt::format("adam.{}.gradient.", i), network.gradients());
    network.update({});
  }
  arrays.add("after.", network.weights());
  arrays.add("updates", features::DType::kInt32, {}, std::vector<std::int32_t>{kUpdates});
  arrays.add("tokens", features::DType::kInt32, {n, as_signed(config().max_words)}, tokens);
  arrays.add("labels", features::DType::kInt32, {steps, n}, environment.labels());
  arrays.add("forward_open", features::DType::kUint8, {steps, n}, environment.forward_open());
  arrays.add("features", features::DType::kFloat32, {steps, n, as_signed(config().features)},
             environment.features());
  add_masks(arrays, {options.seed, 0, dropout ? config().dropout : 0}, longest(tokens));
}

struct Finished {
  int status = -1;
  std::string output;
};
Finished run(const std::string& command) {
  Finished result;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return result;
  std::array<char, 4096> part{};
  while (std::fgets(part.data(), part.size(), pipe) != nullptr) result.output += part.data();
  result.status = pclose(pipe);
  return result;
}

// Debian's packages are the system's Python's, which need not be the first on the path.
std::string python_with_torch() {
  for (const char* python : {"python3", "/usr/bin/python3"}) {
    if (run(fmt::format("{} -c 'import torch, numpy'", python)).status == 0) return python;
  }
  return {};
}

class Numerics : public ::testing::TestWithParam<std::pair<models::Feedback, bool>> {};

TEST_P(Numerics, AgreeWithPyTorchsOwnModules) {
  const std::string python = python_with_torch();
  if (python.empty()) GTEST_SKIP() << "no Python with PyTorch: apt-get install python3-torch";
  const TemporaryFolder folder("numerics");
  const auto file = folder.path() / "case.safetensors";
  Arrays arrays;
  fill(arrays, GetParam().first, GetParam().second);
  arrays.write(file);
  const Finished finished = run(fmt::format("{} {}/tests/python/seq2seq_reference.py {}", python,
                                            EN_SOURCE_DIR, file.string()));
  EXPECT_EQ(finished.status, 0) << finished.output;
  EXPECT_NE(finished.output.find("adam.decoder.decoder2action.bias"), std::string::npos)
      << finished.output;
}

INSTANTIATE_TEST_SUITE_P(, Numerics,
                         ::testing::Values(std::pair(models::Feedback::kTeacher, false),
                                           std::pair(models::Feedback::kTeacher, true),
                                           std::pair(models::Feedback::kSample, true)));

}  // namespace EN_UNIT
}  // namespace enfilade::neural::seq2seq
