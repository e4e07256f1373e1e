#include "enfilade/models/detail/config_json.h"

#include <fmt/format.h>
#include <array>
#include <map>
#include <optional>
#include <utility>

namespace enfilade::models::detail {
namespace {

using json::Element;
using json::Faults;
using json::Path;
using Json = nlohmann::ordered_json;

// As the command line has them.
constexpr std::array<std::string_view, 2> kFeedbacks{"student", "teacher"};

struct Writer {
  Json& out;

  template <class T>
  void operator()(const char* name, const T& value) const {
    out[name] = value;
  }
  void operator()(const char* name, Feedback value) const {
    out[name] = kFeedbacks[value == Feedback::kTeacher ? 1 : 0];
  }
  void operator()(const char* name, const Inputs& value) const { out[name] = to_string(value); }
  void operator()(const char* name, AfterEnd value) const { out[name] = to_string(value); }
  void operator()(const char* name, ForwardTo value) const { out[name] = to_string(value); }
  void operator()(const char* name, const Camera& value) const {
    out[name] = {{"width", value.width},
                 {"height", value.height},
                 {"vertical_field_of_view", to_degrees(value.vertical_field_of_view)}};
  }
};

struct Reader {
  Element root;
  const Path& path;
  Faults& faults;

  std::optional<Element> find(const char* name, bool required = true) const {
    const std::array<json::Field, 1> wanted{{{name, required}}};
    std::array<std::optional<Element>, 1> found;
    json::fields(root, wanted, found, path, faults);
    return found[0];
  }

  template <std::unsigned_integral T>
  void operator()(const char* name, T& value) const {
    const auto found = find(name);
    const auto number = found ? json::integer(*found, Path(path, name), faults) : std::nullopt;
    if (!number) return;
    if (*number < 0) {
      faults.error(Path(path, name), "negative", fmt::format("{}, not 0 or more", *number));
    } else if (!std::in_range<T>(*number)) {
      faults.error(Path(path, name), "out-of-range", fmt::format("{}, too large", *number));
    } else {
      value = static_cast<T>(*number);
    }
  }

  void operator()(const char* name, double& value) const {
    const auto found = find(name);
    if (!found) return;
    value = json::number(*found, Path(path, name), faults).value_or(0);
  }

  void operator()(const char* name, std::string& value) const {
    const auto found = find(name);
    if (found) value = json::string(*found, Path(path, name), faults).value_or("");
  }

  void operator()(const char* name, std::map<std::string, std::string>& value) const {
    const auto found = find(name);
    const Path map_path(path, name);
    const auto object = found ? json::object(*found, map_path, faults) : std::nullopt;
    if (!object) return;
    for (const auto& [key, text] : *object) {
      value[std::string(key)] = json::string(text, Path(map_path, key), faults).value_or("");
    }
  }

  void operator()(const char* name, Camera& value) const {
    const auto found = find(name);
    const Path camera_path(path, name);
    if (!found || !json::object(*found, camera_path, faults)) return;
    const Reader reader{*found, camera_path, faults};
    reader("width", value.width);
    reader("height", value.height);
    double angle = 0;
    reader("vertical_field_of_view", angle);
    value.vertical_field_of_view = degrees(angle);
  }

  void operator()(const char* name, std::vector<std::string>& value) const {
    const auto found = find(name);
    const Path list_path(path, name);
    const auto list = found ? json::array(*found, list_path, faults) : std::nullopt;
    if (!list) return;
    value.clear();
    for (const Element one : *list) {
      const auto text = json::string(one, Path(list_path, value.size()), faults);
      value.emplace_back(text.value_or(""));
    }
  }

  void operator()(const char* name, Feedback& value) const {
    read_name(name, [&](std::string_view text) { value = parse_feedback(text); });
  }
  void operator()(const char* name, Inputs& value) const {
    read_name(name, [&](std::string_view text) { value = parse_inputs(text); });
  }
  void operator()(const char* name, AfterEnd& value) const {
    read_name(name, [&](std::string_view text) { value = parse_after_end(text); });
  }
  void operator()(const char* name, ForwardTo& value) const {
    read_name(name, [&](std::string_view text) { value = parse_forward_to(text); });
  }

  template <class Parse>
  void read_name(const char* name, const Parse& parse) const {
    const auto found = find(name);
    const auto text = found ? json::string(*found, Path(path, name), faults) : std::nullopt;
    if (!text) return;
    try {
      parse(*text);
    } catch (const ArgumentError& error) {
      faults.error(Path(path, name), "unknown-name", error.what());
    }
  }
};

}  // namespace

Json to_json(const NetworkConfig& config) {
  Json out;
  visit_network(config, Writer{out});
  return out;
}

Json to_json(const TrainConfig& config) {
  Json out;
  visit_training(config, Writer{out});
  return out;
}

Json to_json(const DataFingerprint& data) {
  Json out{{"annotations", data.annotations}, {"graphs", data.graphs}};
  if (data.features) visit_features(*data.features, Writer{out["features"]});
  return out;
}

void read(Element element, const Path& path, Faults& faults, NetworkConfig& config) {
  if (json::object(element, path, faults)) visit_network(config, Reader{element, path, faults});
}

void read(Element element, const Path& path, Faults& faults, TrainConfig& config) {
  if (json::object(element, path, faults)) visit_training(config, Reader{element, path, faults});
}

void read(Element element, const Path& path, Faults& faults, DataFingerprint& data) {
  if (!json::object(element, path, faults)) return;
  const Reader reader{element, path, faults};
  reader("annotations", data.annotations);
  reader("graphs", data.graphs);
  const auto found = reader.find("features", false);
  const Path features_path(path, "features");
  if (!found || !json::object(*found, features_path, faults)) return;
  visit_features(data.features.emplace(), Reader{*found, features_path, faults});
}

}  // namespace enfilade::models::detail
