#include "enfilade/models/model_directory.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <set>
#include <system_error>
#include <type_traits>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/names.h"
#include "enfilade/core/numbers.h"
#include "enfilade/core/output_folder.h"

namespace enfilade::models {

namespace {

namespace fs = std::filesystem;

// 64 bits: detects accidental changes, not deliberate ones.
std::string hash_of(std::string_view bytes) {
  return fmt::format("{:016x}", XXH3_64bits(bytes.data(), bytes.size()));
}

std::string hash_of_arrays(std::span<const features::NamedArray> arrays) {
  std::vector<const features::NamedArray*> by_name;
  for (const features::NamedArray& array : arrays) by_name.push_back(&array);
  std::ranges::sort(by_name, {}, [](const features::NamedArray* a) { return a->name; });
  std::string hashes;
  for (const features::NamedArray* array : by_name) {
    const std::string_view bytes(reinterpret_cast<const char*>(array->bytes.data()),
                                 array->bytes.size());
    hashes += array->name + hash_of(bytes);
  }
  return hash_of(hashes);
}

template <class T>
void append(std::string& bytes, const T& value) {
  static_assert(std::is_arithmetic_v<T>);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// With its length, so that "ab", "c" differs from "a", "bc".
void append(std::string& bytes, const std::string& text) {
  append(bytes, text.size());
  bytes += text;
}

std::string hash_of_graph(const graph::NavGraph& graph) {
  std::string bytes;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const ViewpointIndex v(i);
    append(bytes, graph.id(v));
    append(bytes, graph.included(v));
    const Vec3f at = graph.position(v);
    append(bytes, at.x);
    append(bytes, at.y);
    append(bytes, at.z);
    for (const graph::Edge& edge : graph.edges(v)) append(bytes, edge.target.value);
  }
  return hash_of(bytes);
}

std::string text_of(const Camera& camera) {
  return fmt::format("{}x{}, {:g} degrees", camera.width, camera.height,
                     to_degrees(camera.vertical_field_of_view));
}

}  // namespace

void DataFingerprint::add(const tasks::Annotations& split) {
  annotations[split.split] = hash_of(to_json(split));
}

void DataFingerprint::add(const tasks::ContinuousEpisodes& split) {
  annotations[split.split] = hash_of(to_json(split));
}

void DataFingerprint::add_graphs(const tasks::EpisodeSet& episodes) {
  std::set<ScanIndex> scans;
  for (const tasks::ReferencePath& path : episodes.paths) scans.insert(path.scan);
  for (const ScanIndex scan : scans) {
    std::string& hash = graphs[episodes.graphs->scans()[scan.at()]];
    if (hash.empty()) hash = hash_of_graph(episodes.graphs->graph(scan));
  }
}

std::vector<Diagnostic> differences(const DataFingerprint& trained, const DataFingerprint& now,
                                    const std::string& file) {
  std::vector<Diagnostic> found;
  const auto compare = [&](const std::string& where, const char* code, const std::string& before,
                           const std::string& here) {
    if (before == here) return;
    found.push_back({Severity::kWarning, file, "$.data." + where, code,
                     fmt::format("trained on {}, here it is {}", before, here)});
  };
  const auto compare_hashes = [&](const std::string& kind, const char* code, const auto& before,
                                  const auto& here) {
    for (const auto& [name, hash] : before) {
      const auto other = here.find(name);
      if (other != here.end()) compare(fmt::format("{}.{}", kind, name), code, hash, other->second);
    }
  };
  compare_hashes("annotations", "other-annotations", trained.annotations, now.annotations);
  compare_hashes("graphs", "other-graph", trained.graphs, now.graphs);
  if (!trained.features || !now.features) return found;
  const features::FeatureInfo &before = *trained.features, &here = *now.features;
  constexpr const char* kCode = "other-features";
  compare("features.encoder", kCode, before.encoder, here.encoder);
  compare("features.preprocessing", kCode, before.preprocessing, here.preprocessing);
  compare("features.weights", kCode, before.weights, here.weights);
  compare("features.camera", kCode, text_of(before.camera), text_of(here.camera));
  return found;
}

ModelFiles require_model(const fs::path& folder) {
  ModelFiles files{folder};
  for (const fs::path& file : {files.config(), files.weights()}) {
    if (file_exists(file)) continue;
    throw FileError(fmt::format("{}: no {} in it, so it is no model; `enfilade train` makes one",
                                folder.string(), file.filename().string()));
  }
  return files;
}

fs::path ModelFiles::text(TextKind kind) const {
  if (kind == TextKind::kWords) return vocabulary();
  return folder / (kind == TextKind::kWordPieces ? "pieces.txt" : "pieces.model");
}

fs::path ModelFiles::walks(std::size_t set, std::string_view scan) const {
  return folder / "walks" / fmt::format("{:02}", set) / fmt::format("{}.safetensors", scan);
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

void write_file(const ModelFiles& files, const fs::path& file, std::string_view content) {
  OutputFolder(files.folder).write(file.lexically_relative(files.folder).string(), content);
}

void write_state(const fs::path& file, std::span<const features::NamedArray> arrays,
                 std::uint64_t iteration) {
  features::write_safetensors(
      OutputFolder(file.parent_path()).file(file.filename().string()), arrays,
      {{"iteration", std::to_string(iteration)}, {"hash", hash_of_arrays(arrays)}});
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
    refuse(path, "", "bad-iteration",
           fmt::format("iteration {}, not a whole number", quote(digits)));
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
