// The fields of config.json: writing, reading and comparing them.

#include <fmt/format.h>
#include <concepts>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

#include "enfilade/core/detail/json.h"
#include "enfilade/models/model_directory.h"
#include "enfilade/models/train_options.h"

namespace enfilade::models {
namespace {

using json::Element;
using json::Faults;
using json::Path;
using Json = nlohmann::ordered_json;

constexpr std::string_view kFormat = "enfilade-model";
constexpr std::int64_t kVersion = 1;

template <class T, class Object>
concept ConstOrNot = std::same_as<std::remove_const_t<T>, Object>;

// Fields of the table of options as one object.
struct Options {
  std::span<const TrainOption> rows;
  TrainConfig& config;

  template <class Visit>
  void each(const Visit& visit) const {
    for (const TrainOption& row : rows) {
      if (!row.of(config.agent)) continue;
      if (row.rules.applies == nullptr || row.rules.applies(config)) visit(row, row.field(config));
    }
  }
};

// One function for each other object of the file: calls visit(name, field) for each of its fields.

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

struct FieldWriter {
  Json& out;

  template <class T>
  void operator()(std::string_view name, const T& value) const {
    if constexpr (requires { for_fields(value, *this); }) {
      for_fields(value, FieldWriter{out[name]});
    } else {
      out[name] = value;
    }
  }
  template <class T>
  void operator()(std::string_view name, const std::optional<T>& value) const {
    if (value) (*this)(name, *value);
  }
  void operator()(std::string_view name, Radians value) const { out[name] = to_degrees(value); }

  template <class T>
  void write_option(const TrainOption& row, const T* value) const {
    (*this)(row.json, *value);
  }
  void write_option(const TrainOption& row, const NamedField& named) const {
    out[row.json] = named.name(named.value);
  }
};

Json json_of(const Options& options) {
  Json out;
  options.each([&out](const TrainOption& row, const OptionField& field) {
    std::visit([&](const auto& value) { FieldWriter{out}.write_option(row, value); }, field);
  });
  return out;
}

struct FieldReader {
  Element object;
  const Path& path;
  Faults& faults;

  template <class T>
  void operator()(std::string_view name, T& value, bool needed = true) const {
    if (const auto found = json::field(object, {name, needed}, path, faults)) {
      read(*found, Path(path, name), value);
    }
  }
  template <class T>
  void operator()(std::string_view name, std::optional<T>& value, bool /*needed*/ = false) const {
    if (const auto found = json::field(object, {name, false}, path, faults)) {
      read(*found, Path(path, name), value.emplace());
    }
  }

 private:
  template <class T>
  void read(Element element, const Path& at, T& value) const {
    if (json::object(element, at, faults)) for_fields(value, FieldReader{element, at, faults});
  }
  void read(Element element, const Path& at, Options& options) const {
    if (!json::object(element, at, faults)) return;
    const FieldReader fields{element, at, faults};
    options.each([&fields](const TrainOption& row, const OptionField& field) {
      std::visit([&](const auto& value) { fields.read_option(row, value); }, field);
    });
  }
  template <class T>
  void read_option(const TrainOption& row, T* value) const {
    (*this)(row.json, *value, row.rules.needed);
  }
  void read_option(const TrainOption& row, const NamedField& named) const {
    const auto found = json::field(object, {row.json, row.rules.needed}, path, faults);
    if (!found) return;
    read_name(*found, Path(path, row.json),
              [&](std::string_view name) { named.parse(named.value, row.words(), name); });
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
  void read(Element element, const Path& at, AgentKind& value) const {
    read_name(element, at,
              [&](std::string_view name) { value = parse_name<AgentKind>("agent", name); });
  }
  template <class Parse>
  void read_name(Element element, const Path& at, const Parse& parse) const {
    const auto text = json::string(element, at, faults);
    if (!text) return;
    try {
      parse(*text);
    } catch (const ArgumentError& error) {
      faults.error(at, "unknown-name", error.what());
    }
  }
};

// Of its agent.
Json network_json(TrainConfig config) { return json_of({network_options(), config}); }
// Without its network.
Json training_json(TrainConfig config) { return json_of({training_options(), config}); }

// What weights do not depend on.
bool is_free(std::string_view field, Schedule schedule) {
  const bool length = field == "iterations" || field == "sets";
  return (length && schedule == Schedule::kConstant) || field == "validation" ||
         field == "evaluate_every" || field == "checkpoint_every" || field == "final_stop";
}

// Differences of two objects, except the names that are left out.
template <class LeftOut>
void compare_objects(const Json& a, const Json& b, const LeftOut& left_out,
                     std::vector<std::string>& found) {
  const auto text = [](const Json& config, const std::string& name) {
    return config.contains(name) ? config.at(name).dump() : std::string("none");
  };
  Json names = a;
  names.update(b);  // either may lack what it has no value for
  for (const auto& [name, value] : names.items()) {
    const std::string was = text(a, name), is = text(b, name);
    if (left_out(name) || was == is) continue;
    found.push_back(fmt::format("{}: {}, not {}", name, was, is));
  }
}

std::vector<std::string> other_agent(const TrainConfig& there, const TrainConfig& here) {
  if (there.agent == here.agent) return {};
  return {fmt::format("agent: {}, not {}", to_string(there.agent), to_string(here.agent))};
}

}  // namespace

std::string to_json(const ModelConfig& config) {
  Json out{{"format", kFormat}, {"version", kVersion}};
  const FieldWriter write{out};
  write("agent", to_string(config.training.agent));
  write("network", network_json(config.training));
  write("training", training_json(config.training));
  write("data", config.data);
  return out.dump(1) + "\n";
}

ModelConfig load_model_config(const std::filesystem::path& file) {
  const json::Document document = json::Document::load(file);
  const Element root = document.root();
  Faults faults(file.string());
  const Path path;
  ModelConfig config;
  if (json::object(root, path, faults)) {
    const Path format(path, "format");
    const auto found = json::field(root, {"format"}, path, faults);
    if (found && json::string(*found, format, faults) != kFormat) {
      faults.error(format, "other-format", fmt::format("not {}", quote(kFormat)));
    }
    const FieldReader read{root, path, faults};
    read("agent", config.training.agent, false);
    Options network{network_options(), config.training};
    Options training{training_options(), config.training};
    read("network", network);
    read("training", training);
    read("data", config.data);
  }
  faults.throw_if_errors();
  return config;
}

std::vector<std::string> size_differences(const TrainConfig& there, const TrainConfig& here) {
  std::vector<std::string> found = other_agent(there, here);
  if (!found.empty()) return found;
  const auto left_out = [](std::string_view name) {
    return name == "max_words" || name == "inputs" || name == "dropout" ||
           name == "feature_dropout";
  };
  compare_objects(network_json(there), network_json(here), left_out, found);
  return found;
}

std::vector<std::string> differences(const TrainConfig& there, const TrainConfig& here) {
  std::vector<std::string> found = other_agent(there, here);
  if (!found.empty()) return found;
  const auto free = [&](std::string_view name) { return is_free(name, here.schedule); };
  compare_objects(network_json(there), network_json(here), free, found);
  compare_objects(training_json(there), training_json(here), free, found);
  return found;
}

}  // namespace enfilade::models
