#include "enfilade/models/model_directory.h"

#include <fmt/format.h>
#include <algorithm>
#include <system_error>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/numbers.h"
#include "enfilade/models/detail/config_json.h"
#include "enfilade/models/detail/hash.h"

namespace enfilade::models {
namespace {

namespace fs = std::filesystem;

std::string hash_of_arrays(std::span<const features::NamedArray> arrays) {
  std::vector<const features::NamedArray*> by_name;
  for (const features::NamedArray& array : arrays) by_name.push_back(&array);
  std::ranges::sort(by_name, {}, [](const features::NamedArray* a) { return a->name; });
  std::string hashes;
  for (const features::NamedArray* array : by_name) {
    const std::string_view bytes(reinterpret_cast<const char*>(array->bytes.data()),
                                 array->bytes.size());
    hashes += array->name + detail::hash_of(bytes);
  }
  return detail::hash_of(hashes);
}

}  // namespace

ModelFiles require_model(const fs::path& folder) {
  ModelFiles files{folder};
  for (const fs::path& file : {files.config(), files.weights()}) {
    if (fs::exists(file)) continue;
    throw FileError(fmt::format("{}: no {} in it, so it is no model; `enfilade train` makes one",
                                folder.string(), file.filename().string()));
  }
  return files;
}

fs::path ModelFiles::text(TextKind kind) const {
  if (kind == TextKind::kWords) return vocabulary();
  return folder / (kind == TextKind::kWordPieces ? "pieces.txt" : "pieces.model");
}

fs::path ModelFiles::results(std::string_view split) const {
  return folder / "results" / fmt::format("{}.json", split);
}

fs::path ModelFiles::walks(std::size_t set, std::string_view scan) const {
  return folder / "walks" / fmt::format("{:02}", set) / fmt::format("{}.safetensors", scan);
}

fs::path ModelFiles::attention(std::string_view split) const {
  return folder / "results" / fmt::format("{}.attention.json", split);
}

std::string to_json(const ModelConfig& config) { return detail::to_json(config).dump(1) + "\n"; }

ModelConfig load_model_config(const fs::path& file) {
  const json::Document document = json::Document::load(file);
  json::Faults faults(file.string());
  ModelConfig config = detail::read_config(document.root(), faults);
  faults.throw_if_errors();
  return config;
}

tasks::Vocabulary load_vocabulary(const ModelFiles& files, const NetworkConfig& network) {
  tasks::Vocabulary vocabulary = tasks::Vocabulary::load(files.vocabulary());
  if (vocabulary.size() != network.vocabulary) {
    refuse(files.vocabulary(), "", "wrong-size",
           fmt::format("{} words, but the network was made for {}", vocabulary.size(),
                       network.vocabulary));
  }
  return vocabulary;
}

InstructionWords load_instruction_words(const ModelFiles& files, const TrainConfig& training) {
  const NetworkConfig& network = training.network;
  if (training.text == TextKind::kWords) return InstructionWords(load_vocabulary(files, network));
  const fs::path file = files.text(training.text);
  Subwords pieces = training.text == TextKind::kWordPieces
                        ? Subwords::load_word_pieces(file, training.letters)
                        : Subwords::load_sentence_pieces(file);
  if (pieces.size() != network.vocabulary) {
    refuse(file, "", "wrong-size",
           fmt::format("{} pieces, but the network was made for {}", pieces.size(),
                       network.vocabulary));
  }
  return InstructionWords(std::move(pieces));
}

const features::FeatureSet* usable_features(const ModelConfig& config,
                                            const features::FeatureSet* features) {
  const NetworkConfig& network = config.training.network;
  if (!network.inputs.vision) return nullptr;
  if (features == nullptr) {
    throw ArgumentError("the agent sees, so it needs features (--features FILE)");
  }
  if (features->info().dimensions != network.features) {
    throw ArgumentError(fmt::format("features of {} numbers a view; the network was made for {}",
                                    features->info().dimensions, network.features));
  }
  return features;
}

void write_state(const fs::path& file, std::span<const features::NamedArray> arrays,
                 std::uint64_t iteration) {
  features::write_safetensors(
      file, arrays, {{"iteration", std::to_string(iteration)}, {"hash", hash_of_arrays(arrays)}});
}

StateFile open_state(const fs::path& path) {
  StateFile state{features::TensorFile::open(path), 0};
  const auto& metadata = state.file.metadata();
  const auto iteration = metadata.find("iteration"), hash = metadata.find("hash");
  if (iteration == metadata.end() || hash == metadata.end()) {
    refuse(path, "", "no-state", "no iteration or hash in it; not written by Enfilade's training");
  }
  const std::string& digits = iteration->second;
  const auto number = parse_number<std::uint64_t>(digits);
  if (!number) {
    refuse(path, "", "bad-iteration", fmt::format("iteration {:?}, not a whole number", digits));
  }
  state.iteration = *number;
  if (hash->second != hash_of_arrays(state.file.arrays())) {
    refuse(path, "", "broken", "its bytes are not those that were written");
  }
  return state;
}

void write_checkpoint(const ModelFiles& files, std::span<const features::NamedArray> checkpoint,
                      std::span<const features::NamedArray> weights, std::uint64_t iteration) {
  std::error_code ignored;
  if (fs::exists(files.checkpoint(), ignored)) {
    // A second link, so that the old checkpoint stays complete whatever happens during the writing
    // of the new one. On file systems without links no previous checkpoint is kept.
    fs::remove(files.previous_checkpoint(), ignored);
    fs::create_hard_link(files.checkpoint(), files.previous_checkpoint(), ignored);
  }
  write_state(files.checkpoint(), checkpoint, iteration);
  write_state(files.weights(), weights, iteration);
}

}  // namespace enfilade::models
