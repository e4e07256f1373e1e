#include "enfilade/models/detail/config_json.h"

#include <fmt/format.h>
#include <array>
#include <optional>

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
};

struct Reader {
  Element root;
  const Path& path;
  Faults& faults;

  std::optional<Element> find(const char* name) const {
    const std::array<json::Field, 1> wanted{{{name}}};
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
      return;
    }
    value = static_cast<T>(*number);
  }

  void operator()(const char* name, double& value) const {
    const auto found = find(name);
    if (!found) return;
    value = json::number(*found, Path(path, name), faults).value_or(0);
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

void read(Element element, const Path& path, Faults& faults, NetworkConfig& config) {
  if (json::object(element, path, faults)) visit_network(config, Reader{element, path, faults});
}

void read(Element element, const Path& path, Faults& faults, TrainConfig& config) {
  if (json::object(element, path, faults)) visit_training(config, Reader{element, path, faults});
}

}  // namespace enfilade::models::detail
