#include "enfilade/models/detail/config_json.h"

#include <fmt/format.h>
#include <array>
#include <concepts>
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

// One function for each object of the file: calls visit(name, field) for each of its fields.

void for_fields(ConstOrNot<NetworkConfig> auto& config, const auto& visit) {
  visit("vocabulary", config.vocabulary);
  visit("max_words", config.max_words);
  visit("word_embedding", config.word_embedding);
  visit("hidden", config.hidden);
  visit("action_embedding", config.action_embedding);
  visit("features", config.features);
  visit("dropout", config.dropout);
  visit("inputs", config.inputs);
}

// Without its network, which is an object beside it.
void for_fields(ConstOrNot<TrainConfig> auto& config, const auto& visit) {
  visit("feedback", config.feedback);
  visit("iterations", config.iterations);
  visit("batch_size", config.batch_size);
  visit("max_steps", config.max_steps);
  visit("after_end", config.after_end);
  visit("forward", config.forward);
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
  visit("network", config.training.network);
  visit("training", config.training);
  visit("data", config.data);
}

struct Writer {
  Json& out;

  template <class T>
  void operator()(const char* name, const T& value) const {
    if constexpr (requires { for_fields(value, *this); }) {
      for_fields(value, Writer{out[name]});
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
  void operator()(const char* name, AfterEnd value) const { out[name] = to_string(value); }
  void operator()(const char* name, ForwardTo value) const { out[name] = to_string(value); }
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
  template <class T>
  void operator()(const char* name, std::optional<T>& value) const {
    if (const auto found = json::field(object, {name, false}, path, faults)) {
      read(*found, Path(path, name), value.emplace());
    }
  }

 private:
  template <class T>
  void read(Element element, const Path& at, T& value) const {
    if (json::object(element, at, faults)) for_fields(value, Reader{element, at, faults});
  }
  template <std::unsigned_integral T>
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

Json to_json(const NetworkConfig& config) { return json_of(config); }
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
