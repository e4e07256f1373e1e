#include "enfilade/models/model_directory.h"

#include <fmt/format.h>
#include <algorithm>
#include <charconv>
#include <system_error>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/models/detail/config_json.h"
#include "enfilade/models/detail/hash.h"

namespace enfilade::models {
namespace {

namespace fs = std::filesystem;
using json::Element;
using json::Faults;
using json::Path;
using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "enfilade-model";
constexpr std::int64_t kVersion = 1;

Json features_json(const features::FeatureInfo& info) {
  return {{"encoder", info.encoder},
          {"preprocessing", info.preprocessing},
          {"weights", info.weights},
          {"dimensions", info.dimensions},
          {"camera",
           {{"width", info.camera.width},
            {"height", info.camera.height},
            {"vertical_field_of_view", to_degrees(info.camera.vertical_field_of_view)}}}};
}

// Reads the parts of config.json that are not the configs.
class ConfigReader {
 public:
  explicit ConfigReader(const fs::path& file)
      : document_(json::Document::load(file)), faults_(file.string()) {}

  ModelConfig read() {
    const Path path;
    const auto found =
        fields<4>(document_.root(), {{{"format"}, {"network"}, {"training"}, {"data"}}}, path);
    ModelConfig config;
    if (found[0] && text(*found[0], Path(path, "format")) != kFormat) {
      faults_.error(Path(path, "format"), "other-format", fmt::format("not {:?}", kFormat));
    }
    if (found[1]) {
      detail::read(*found[1], Path(path, "network"), faults_, config.training.network);
    }
    if (found[2]) detail::read(*found[2], Path(path, "training"), faults_, config.training);
    if (found[3]) read_data(*found[3], Path(path, "data"), config.data);
    faults_.throw_if_errors();
    return config;
  }

 private:
  template <std::size_t N>
  std::array<std::optional<Element>, N> fields(Element element,
                                               const std::array<json::Field, N>& wanted,
                                               const Path& path) {
    std::array<std::optional<Element>, N> found;
    if (json::object(element, path, faults_)) json::fields(element, wanted, found, path, faults_);
    return found;
  }

  std::string text(Element element, const Path& path) {
    return std::string(json::string(element, path, faults_).value_or(""));
  }

  void read_data(Element element, const Path& path, DataFingerprint& data) {
    const auto found =
        fields<3>(element, {{{"annotations"}, {"graphs"}, {"features", false}}}, path);
    if (found[0]) read_hashes(*found[0], Path(path, "annotations"), data.annotations);
    if (found[1]) read_hashes(*found[1], Path(path, "graphs"), data.graphs);
    if (found[2]) data.features = read_features(*found[2], Path(path, "features"));
  }

  void read_hashes(Element element, const Path& path, std::map<std::string, std::string>& hashes) {
    const auto object = json::object(element, path, faults_);
    if (!object) return;
    for (const auto& [name, hash] : *object)
      hashes[std::string(name)] = text(hash, Path(path, name));
  }

  features::FeatureInfo read_features(Element element, const Path& path) {
    const auto found = fields<5>(
        element, {{{"encoder"}, {"preprocessing"}, {"weights"}, {"dimensions"}, {"camera"}}}, path);
    features::FeatureInfo info;
    if (found[0]) info.encoder = text(*found[0], Path(path, "encoder"));
    if (found[1]) info.preprocessing = text(*found[1], Path(path, "preprocessing"));
    if (found[2]) info.weights = text(*found[2], Path(path, "weights"));
    if (found[3])
      info.dimensions = static_cast<std::size_t>(number(*found[3], Path(path, "dimensions")));
    if (found[4]) info.camera = read_camera(*found[4], Path(path, "camera"));
    return info;
  }

  Camera read_camera(Element element, const Path& path) {
    const auto found =
        fields<3>(element, {{{"width"}, {"height"}, {"vertical_field_of_view"}}}, path);
    Camera camera;
    if (found[0]) camera.width = static_cast<std::uint32_t>(number(*found[0], Path(path, "width")));
    if (found[1])
      camera.height = static_cast<std::uint32_t>(number(*found[1], Path(path, "height")));
    if (found[2]) {
      camera.vertical_field_of_view =
          degrees(number(*found[2], Path(path, "vertical_field_of_view")));
    }
    return camera;
  }

  // Of sizes: 0 to 2^32 - 1.
  double number(Element element, const Path& path) {
    const double value = json::number(element, path, faults_).value_or(0);
    if (value >= 0 && value < 4294967296.0) return value;
    faults_.error(path, "out-of-range", fmt::format("{}, not from 0 to 2^32 - 1", value));
    return 0;
  }

  json::Document document_;
  Faults faults_;
};

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

fs::path ModelFiles::results(std::string_view split) const {
  return folder / "results" / fmt::format("{}.json", split);
}

fs::path ModelFiles::attention(std::string_view split) const {
  return folder / "results" / fmt::format("{}.attention.json", split);
}

std::string to_json(const ModelConfig& config) {
  Json data{{"annotations", config.data.annotations}, {"graphs", config.data.graphs}};
  if (config.data.features) data["features"] = features_json(*config.data.features);
  const Json json{{"format", kFormat},
                  {"version", kVersion},
                  {"network", detail::to_json(config.training.network)},
                  {"training", detail::to_json(config.training)},
                  {"data", std::move(data)}};
  return json.dump(1) + "\n";
}

ModelConfig load_model_config(const fs::path& file) { return ConfigReader(file).read(); }

r2r::Vocabulary load_vocabulary(const ModelFiles& files, const NetworkConfig& network) {
  r2r::Vocabulary vocabulary = r2r::Vocabulary::load(files.vocabulary());
  if (vocabulary.size() != network.vocabulary) {
    refuse(files.vocabulary(), "", "wrong-size",
           fmt::format("{} words, but the network was made for {}", vocabulary.size(),
                       network.vocabulary));
  }
  return vocabulary;
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
  const auto [end, code] =
      std::from_chars(digits.data(), digits.data() + digits.size(), state.iteration);
  if (code != std::errc() || end != digits.data() + digits.size()) {
    refuse(path, "", "bad-iteration", fmt::format("iteration {:?}, not a whole number", digits));
  }
  if (hash->second != hash_of_arrays(state.file.arrays())) {
    refuse(path, "", "broken", "its bytes are not those that were written");
  }
  return state;
}

void write_checkpoint(const ModelFiles& files, std::span<const features::NamedArray> checkpoint,
                      std::span<const features::NamedArray> weights, std::uint64_t iteration) {
  std::error_code ignored;
  if (fs::exists(files.checkpoint(), ignored)) {
    // A second name, so that the old one is whole under one of them whatever happens now. Where the
    // file system has no links there is no checkpoint before, only this one.
    fs::remove(files.previous_checkpoint(), ignored);
    fs::create_hard_link(files.checkpoint(), files.previous_checkpoint(), ignored);
  }
  write_state(files.checkpoint(), checkpoint, iteration);
  write_state(files.weights(), weights, iteration);
}

}  // namespace enfilade::models
