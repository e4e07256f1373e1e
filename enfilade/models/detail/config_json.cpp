#include "enfilade/models/detail/config_json.h"

#include <fmt/format.h>
#include <array>
#include <concepts>
#include <cstdint>
#include <map>
#include <optional>
#include <type_traits>

namespace enfilade::models::detail {
namespace {

using json::Element;
using json::Faults;
using json::Path;
using Json = nlohmann::ordered_json;

constexpr std::string_view kFormat = "enfilade-model";
constexpr std::int64_t kVersion = 1;

// As the command line has them.
constexpr std::array<std::string_view, 2> kFeedbacks{"student", "teacher"};

template <class T, class Object>
concept ConstOrNot = std::same_as<std::remove_const_t<T>, Object>;

// Enumerations whose values have names.
template <class T>
concept Named =
    std::same_as<T, AfterEnd> || std::same_as<T, ForwardTo> || std::same_as<T, AgentKind> ||
    std::same_as<T, Optimizer> || std::same_as<T, Schedule> || std::same_as<T, SampledLoss> ||
    std::same_as<T, MapTeacher> || std::same_as<T, FinalStop> || std::same_as<T, Stage> ||
    std::same_as<T, TextKind> || std::same_as<T, Letters> || std::same_as<T, Subout> ||
    std::same_as<T, Fusion>;

// One function for each object of the file: calls visit(name, field) for each of its fields.

// What follows from the data stands beside it.
void for_sizes(ConstOrNot<PanoramicConfig> auto& sizes, const auto& visit) {
  visit("word_embedding", sizes.word_embedding);
  visit("action_embedding", sizes.action_embedding);
  visit("hidden", sizes.hidden);
  visit("angle", sizes.angle);
  visit("bidirectional", sizes.bidirectional);
  visit("subout", sizes.subout);
  visit("dropout", sizes.dropout);
  visit("feature_dropout", sizes.feature_dropout);
}

void for_sizes(ConstOrNot<SpeakerConfig> auto& sizes, const auto& visit) {
  visit("word_embedding", sizes.word_embedding);
  visit("hidden", sizes.hidden);
  visit("angle", sizes.angle);
  visit("bidirectional", sizes.bidirectional);
  visit("dropout", sizes.dropout);
  visit("feature_dropout", sizes.feature_dropout);
}

void for_sizes(ConstOrNot<DuetConfig> auto& sizes, const auto& visit) {
  visit("hidden", sizes.hidden);
  visit("heads", sizes.heads);
  visit("feed_forward", sizes.feed_forward);
  visit("panorama_feed_forward", sizes.panorama_feed_forward);
  visit("text_layers", sizes.text_layers);
  visit("panorama_layers", sizes.panorama_layers);
  visit("cross_layers", sizes.cross_layers);
  visit("positions", sizes.positions);
  visit("token_types", sizes.token_types);
  visit("steps", sizes.steps);
  visit("object", sizes.object);
  visit("fusion", sizes.fusion);
  visit("map_distances", sizes.map_distances);
  visit("dropout", sizes.dropout);
  visit("feature_dropout", sizes.feature_dropout);
}

void for_sizes(ConstOrNot<Seq2SeqCeConfig> auto& sizes, const auto& visit) {
  visit("word_embedding", sizes.word_embedding);
  visit("sentence", sizes.sentence);
  visit("picture", sizes.picture);
  visit("depth", sizes.depth);
  visit("action_embedding", sizes.action_embedding);
  visit("hidden", sizes.hidden);
}

// The network of a training's agent.
template <class Training>
struct NetworkPart {
  Training& training;
};
template <class Training>
void for_fields(const NetworkPart<Training>& part, const auto& visit) {
  auto& network = part.training.network;
  visit("vocabulary", network.vocabulary);
  visit("max_words", network.max_words);
  visit("features", network.features);
  visit("inputs", network.inputs);
  if (part.training.agent != AgentKind::kSeq2Seq && part.training.agent != AgentKind::kSeq2SeqCe) {
    visit("text", part.training.text);
    if (part.training.text == TextKind::kWordPieces) visit("letters", part.training.letters);
  }
  switch (part.training.agent) {
    case AgentKind::kSeq2Seq:
      visit("word_embedding", network.word_embedding);
      visit("hidden", network.hidden);
      visit("action_embedding", network.action_embedding);
      visit("dropout", network.dropout);
      break;
    case AgentKind::kPanoramic:
      for_sizes(part.training.panoramic, visit);
      break;
    case AgentKind::kDuet:
      for_sizes(part.training.duet, visit);
      break;
    case AgentKind::kSpeaker:
      for_sizes(part.training.speaker, visit);
      break;
    case AgentKind::kSeq2SeqCe:
      for_sizes(part.training.seq2seq_ce, visit);
      break;
  }
}

// Without its network, which is an object beside it.
void for_fields(ConstOrNot<TrainConfig> auto& config, const auto& visit) {
  const bool free = config.agent == AgentKind::kSeq2SeqCe;
  if (!free) visit("feedback", config.feedback);
  visit("iterations", config.iterations);
  visit("batch_size", config.batch_size);
  visit("parts", config.parts);
  visit("max_steps", config.max_steps);
  if (config.agent == AgentKind::kSeq2Seq) {
    visit("after_end", config.after_end);
    visit("forward", config.forward);
  } else {
    visit("optimizer", config.optimizer);
    visit("clip", config.clip);
    visit("warm_up", config.warm_up);
    visit("schedule", config.schedule);
    if (config.agent != AgentKind::kSpeaker && !free) {
      visit("teacher_weight", config.teacher_weight);
    }
  }
  if (free) {
    visit("inflection", config.seq2seq_ce.inflection);
    visit("sets", config.seq2seq_ce.sets);
    visit("set_walks", config.seq2seq_ce.set_walks);
    visit("epochs", config.seq2seq_ce.epochs);
    visit("teacher_share", config.seq2seq_ce.teacher_share);
  }
  if (config.agent == AgentKind::kPanoramic) visit("sampled_loss", config.sampled_loss);
  if (config.agent == AgentKind::kDuet) {
    visit("map_teacher", config.map_teacher);
    visit("final_stop", config.final_stop);
    visit("stage", config.stage);
    visit("initial_weights", config.initial_weights);
  }
  visit("seed", config.seed);
  visit("splits", config.splits);
  visit("buildings", config.buildings);
  visit("least_count", config.least_count);
  visit("learning_rate", config.adam.learning_rate);
  visit("beta1", config.adam.beta1);
  visit("beta2", config.adam.beta2);
  visit("epsilon", config.adam.epsilon);
  visit("weight_decay", config.adam.weight_decay);
  visit("validation", config.validation);
  visit("evaluate_every", config.evaluate_every);
  visit("checkpoint_every", config.checkpoint_every);
}

void for_fields(ConstOrNot<Camera> auto& camera, const auto& visit) {
  visit("width", camera.width);
  visit("height", camera.height);
  visit("vertical_field_of_view", camera.vertical_field_of_view);
}

void for_fields(ConstOrNot<features::FeatureInfo> auto& info, const auto& visit) {
  visit("encoder", info.encoder);
  visit("preprocessing", info.preprocessing);
  visit("weights", info.weights);
  visit("dimensions", info.dimensions);
  visit("camera", info.camera);
}

void for_fields(ConstOrNot<DataFingerprint> auto& data, const auto& visit) {
  visit("annotations", data.annotations);
  visit("graphs", data.graphs);
  visit("features", data.features);
}

void for_fields(ConstOrNot<ModelConfig> auto& config, const auto& visit) {
  visit("agent", config.training.agent);
  const NetworkPart network{config.training};
  visit("network", network);
  visit("training", config.training);
  visit("data", config.data);
}

struct Writer {
  Json& out;

  template <class T>
  void operator()(const char* name, const T& value) const {
    if constexpr (requires { for_fields(value, *this); }) {
      for_fields(value, Writer{out[name]});
    } else if constexpr (Named<T>) {
      out[name] = to_string(value);
    } else {
      out[name] = value;
    }
  }
  template <class T>
  void operator()(const char* name, const std::optional<T>& value) const {
    if (value) (*this)(name, *value);
  }
  void operator()(const char* name, Feedback value) const {
    out[name] = kFeedbacks[value == Feedback::kTeacher ? 1 : 0];
  }
  void operator()(const char* name, const Inputs& value) const { out[name] = to_string(value); }
  void operator()(const char* name, Radians value) const { out[name] = to_degrees(value); }
};

struct Reader {
  Element object;
  const Path& path;
  Faults& faults;

  template <class T>
  void operator()(const char* name, T& value) const {
    if (const auto found = json::field(object, {name}, path, faults)) {
      read(*found, Path(path, name), value);
    }
  }
  // Files of before there were several kinds of agents, of texts, of stages or of final stops, have
  // none.
  void operator()(const char* name, AgentKind& value) const { read_if_there(name, value); }
  void operator()(const char* name, TextKind& value) const { read_if_there(name, value); }
  void operator()(const char* name, Stage& value) const { read_if_there(name, value); }
  void operator()(const char* name, FinalStop& value) const { read_if_there(name, value); }
  void operator()(const char* name, Letters& value) const { read_if_there(name, value); }
  template <class T>
  void operator()(const char* name, std::optional<T>& value) const {
    if (const auto found = json::field(object, {name, false}, path, faults)) {
      read(*found, Path(path, name), value.emplace());
    }
  }

 private:
  template <class T>
  void read_if_there(const char* name, T& value) const {
    if (const auto found = json::field(object, {name, false}, path, faults)) {
      read(*found, Path(path, name), value);
    }
  }
  template <class T>
  void read(Element element, const Path& at, T& value) const {
    if (json::object(element, at, faults)) for_fields(value, Reader{element, at, faults});
  }
  void read(Element element, const Path& at, bool& value) const {
    value = json::boolean(element, at, faults).value_or(false);
  }
  template <std::integral T>
  void read(Element element, const Path& at, T& value) const {
    const auto number = json::integer(element, at, faults);
    if (!number) return;
    if (*number < 0) {
      faults.error(at, "negative", fmt::format("{}, not 0 or more", *number));
    } else if (!std::in_range<T>(*number)) {
      faults.error(at, "out-of-range", fmt::format("{}, too large", *number));
    } else {
      value = static_cast<T>(*number);
    }
  }
  void read(Element element, const Path& at, double& value) const {
    value = json::number(element, at, faults).value_or(0);
  }
  void read(Element element, const Path& at, Radians& value) const {
    value = degrees(json::number(element, at, faults).value_or(0));
  }
  void read(Element element, const Path& at, std::string& value) const {
    value = json::string(element, at, faults).value_or("");
  }
  void read(Element element, const Path& at, std::vector<std::string>& value) const {
    value = json::strings(element, at, faults);
  }
  void read(Element element, const Path& at, std::map<std::string, std::string>& value) const {
    const auto entries = json::object(element, at, faults);
    if (!entries) return;
    for (const auto& [key, text] : *entries) read(text, Path(at, key), value[std::string(key)]);
  }
  void read(Element element, const Path& at, Feedback& value) const {
    read_name(element, at, value, parse_feedback);
  }
  void read(Element element, const Path& at, Inputs& value) const {
    read_name(element, at, value, parse_inputs);
  }
  void read(Element element, const Path& at, AfterEnd& value) const {
    read_name(element, at, value, parse_after_end);
  }
  void read(Element element, const Path& at, ForwardTo& value) const {
    read_name(element, at, value, parse_forward_to);
  }
  void read(Element element, const Path& at, AgentKind& value) const {
    read_name(element, at, value, parse_agent_kind);
  }
  void read(Element element, const Path& at, Optimizer& value) const {
    read_name(element, at, value, parse_optimizer);
  }
  void read(Element element, const Path& at, Schedule& value) const {
    read_name(element, at, value, parse_schedule);
  }
  void read(Element element, const Path& at, SampledLoss& value) const {
    read_name(element, at, value, parse_sampled_loss);
  }
  void read(Element element, const Path& at, MapTeacher& value) const {
    read_name(element, at, value, parse_map_teacher);
  }
  void read(Element element, const Path& at, FinalStop& value) const {
    read_name(element, at, value, parse_final_stop);
  }
  void read(Element element, const Path& at, TextKind& value) const {
    read_name(element, at, value, parse_text_kind);
  }
  void read(Element element, const Path& at, Letters& value) const {
    read_name(element, at, value, parse_letters);
  }
  void read(Element element, const Path& at, Stage& value) const {
    read_name(element, at, value, parse_stage);
  }
  void read(Element element, const Path& at, Subout& value) const {
    read_name(element, at, value, parse_subout);
  }
  void read(Element element, const Path& at, Fusion& value) const {
    read_name(element, at, value, parse_fusion);
  }

  template <class T>
  void read_name(Element element, const Path& at, T& value, T (*parse)(std::string_view)) const {
    const auto text = json::string(element, at, faults);
    if (!text) return;
    try {
      value = parse(*text);
    } catch (const ArgumentError& error) {
      faults.error(at, "unknown-name", error.what());
    }
  }
};

template <class T>
Json json_of(const T& config) {
  Json out;
  for_fields(config, Writer{out});
  return out;
}

}  // namespace

Json network_to_json(const TrainConfig& config) {
  return json_of(NetworkPart<const TrainConfig>{config});
}
Json to_json(const TrainConfig& config) { return json_of(config); }

Json to_json(const ModelConfig& config) {
  Json out{{"format", kFormat}, {"version", kVersion}};
  for_fields(config, Writer{out});
  return out;
}

ModelConfig read_config(Element root, Faults& faults) {
  const Path path;
  ModelConfig config;
  if (!json::object(root, path, faults)) return config;
  const Path format(path, "format");
  const auto found = json::field(root, {"format"}, path, faults);
  if (found && json::string(*found, format, faults) != kFormat) {
    faults.error(format, "other-format", fmt::format("not {:?}", kFormat));
  }
  for_fields(config, Reader{root, path, faults});
  return config;
}

}  // namespace enfilade::models::detail
