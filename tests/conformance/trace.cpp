#include "tests/conformance/trace.h"

#include <fmt/format.h>
#include <zlib.h>
#include <array>
#include <cerrno>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include "enfilade/core/detail/json.h"

namespace enfilade::tests {
namespace {

using json::Element;
using json::Faults;
using json::Field;
using json::Path;

// Values that a line must have. What is missing or of another kind becomes a fault of the line and
// something harmless here, so that all faults of a line are found at once.
class Line {
 public:
  Line(const Path& path, Faults& faults) : path_(path), faults_(faults) {}

  double number(Element element, std::string_view name) {
    return json::number(element, Path(path_, name), faults_).value_or(0);
  }
  std::int64_t integer(Element element, std::string_view name) {
    return json::integer(element, Path(path_, name), faults_).value_or(0);
  }
  std::string string(Element element, std::string_view name) {
    return std::string(json::string(element, Path(path_, name), faults_).value_or(""));
  }

 private:
  const Path& path_;
  Faults& faults_;
};

// The elements of an array of a known length.
template <std::size_t N>
std::optional<std::array<Element, N>> tuple(Element element, const Path& path, Faults& faults) {
  const auto values = json::array(element, path, faults);
  if (!values) return std::nullopt;
  if (values->size() != N) {
    faults.error(path, "wrong-length", fmt::format("array of {}, not of {}", values->size(), N));
    return std::nullopt;
  }
  std::array<Element, N> found;
  std::size_t i = 0;
  for (const Element value : *values) found[i++] = value;
  return found;
}

double number_at(Element element, const Path& path, std::size_t i, Faults& faults) {
  return json::number(element, Path(path, i), faults).value_or(0);
}

void read_elevation_limits(Element element, const Path& path, Faults& faults,
                           sim::ElevationLimits& limits) {
  const auto pair = tuple<2>(element, path, faults);
  if (!pair) return;
  limits.min = Radians(number_at((*pair)[0], path, 0, faults));
  limits.max = Radians(number_at((*pair)[1], path, 1, faults));
}

std::uint32_t read_pixels(Element element, const Path& path, Faults& faults) {
  const std::int64_t pixels = json::integer(element, path, faults).value_or(1);
  if (pixels >= 1 && pixels <= 1 << 20) return static_cast<std::uint32_t>(pixels);
  faults.error(path, "bad-size", fmt::format("{} pixels: 1 to {} are allowed", pixels, 1 << 20));
  return 1;
}

// `config` holds the defaults; changes what the object names.
void read_config(Element element, const Path& path, Faults& faults, sim::SimulatorConfig& config) {
  const auto options = json::object(element, path, faults);
  if (!options) return;
  for (const auto [name, value] : *options) {
    const Path at(path, name);
    if (name == "width") {
      config.camera.width = read_pixels(value, at, faults);
    } else if (name == "height") {
      config.camera.height = read_pixels(value, at, faults);
    } else if (name == "vfov") {
      config.camera.vertical_field_of_view = Radians(json::number(value, at, faults).value_or(1));
    } else if (name == "discretized") {
      const bool on = json::boolean(value, at, faults).value_or(false);
      config.viewing = on ? sim::Viewing::kDiscretized : sim::Viewing::kContinuous;
    } else if (name == "restricted") {
      const bool on = json::boolean(value, at, faults).value_or(false);
      config.navigation = on ? sim::Navigation::kRestricted : sim::Navigation::kUnrestricted;
    } else if (name == "elevation_limits") {
      read_elevation_limits(value, at, faults, config.elevation_limits);
    } else {
      // Replaying without it would compare two different things.
      faults.error(at, "unknown-option",
                   "not one of width, height, vfov, discretized, restricted, elevation_limits");
    }
  }
}

TraceHeader read_header(Element root, Faults& faults) {
  constexpr std::array<Field, 3> kWanted{{{"header"}, {"configs"}, {"defaults", false}}};
  std::array<std::optional<Element>, 3> found;
  TraceHeader header;
  const Path path;
  if (!json::fields(root, kWanted, found, path, faults)) return header;
  sim::SimulatorConfig defaults = sim::SimulatorConfig::mattersim();
  defaults.max_navigable = 256;  // as many as any building may need
  if (found[2]) read_config(*found[2], Path(path, "defaults"), faults, defaults);
  const Path configs_path(path, "configs");
  const auto configs = json::object(*found[1], configs_path, faults);
  if (!configs) return header;
  for (const auto [name, value] : *configs) {
    const Path at(configs_path, name);
    sim::SimulatorConfig config = defaults;
    read_config(value, at, faults, config);
    try {
      validate(config);
    } catch (const ArgumentError& error) {
      faults.error(at, "bad-config", error.what());
    }
    header.configs.emplace(name, config);
  }
  return header;
}

std::variant<TraceStart, sim::Action> read_action(Element element, const Path& path,
                                                  Faults& faults) {
  constexpr std::array<Field, 2> kWanted{{{"new", false}, {"act", false}}};
  std::array<std::optional<Element>, 2> found;
  if (!json::fields(element, kWanted, found, path, faults)) return {};
  if (found[0].has_value() == found[1].has_value()) {
    faults.error(path, "bad-action", "exactly one of \"new\" and \"act\" is needed");
    return {};
  }
  const Path at(path, found[0] ? "new" : "act");
  const auto values = tuple<3>(found[0] ? *found[0] : *found[1], at, faults);
  if (!values) return {};
  const double second = number_at((*values)[1], at, 1, faults);
  const double third = number_at((*values)[2], at, 2, faults);
  const Path first_path(at, std::size_t{0});
  if (found[0]) {
    const auto id = json::string((*values)[0], first_path, faults);
    return TraceStart{std::string(id.value_or("")), second, third};
  }
  const std::int64_t index = json::integer((*values)[0], first_path, faults).value_or(0);
  if (index < 0 || index > UINT32_MAX) {
    faults.error(first_path, "bad-index", fmt::format("index {}: 0 or more", index));
  }
  return sim::Action{static_cast<std::uint32_t>(index), Radians(second), Radians(third)};
}

std::vector<TraceNavigable> read_navigable(Element element, const Path& path, Faults& faults) {
  std::vector<TraceNavigable> list;
  const auto rows = json::array(element, path, faults);
  if (!rows) return list;
  for (const Element row : *rows) {
    const Path at(path, list.size());
    TraceNavigable& entry = list.emplace_back();
    const auto values = tuple<5>(row, at, faults);
    if (!values) continue;
    entry.viewpoint = json::string((*values)[0], Path(at, std::size_t{0}), faults).value_or("");
    entry.ix = json::integer((*values)[1], Path(at, 1), faults).value_or(0);
    entry.rel_heading = number_at((*values)[2], at, 2, faults);
    entry.rel_elevation = number_at((*values)[3], at, 3, faults);
    entry.distance = number_at((*values)[4], at, 4, faults);
  }
  return list;
}

TraceState read_state(Element element, const Path& path, Faults& faults) {
  constexpr std::array<Field, 11> kWanted{{{"scanId"},
                                           {"step"},
                                           {"viewpointId"},
                                           {"ix"},
                                           {"x"},
                                           {"y"},
                                           {"z"},
                                           {"heading"},
                                           {"elevation"},
                                           {"viewIndex"},
                                           {"nav"}}};
  std::array<std::optional<Element>, kWanted.size()> found;
  TraceState state;
  if (!json::fields(element, kWanted, found, path, faults)) return state;
  Line line(path, faults);
  state.scan = line.string(*found[0], "scanId");
  state.step = line.integer(*found[1], "step");
  state.viewpoint = line.string(*found[2], "viewpointId");
  state.ix = line.integer(*found[3], "ix");
  state.x = line.number(*found[4], "x");
  state.y = line.number(*found[5], "y");
  state.z = line.number(*found[6], "z");
  state.heading = line.number(*found[7], "heading");
  state.elevation = line.number(*found[8], "elevation");
  state.view_index = line.integer(*found[9], "viewIndex");
  state.navigable = read_navigable(*found[10], Path(path, "nav"), faults);
  return state;
}

TraceStep read_step(Element root, const TraceHeader& header, Faults& faults) {
  constexpr std::array<Field, 4> kWanted{{{"s"}, {"c"}, {"a"}, {"st"}}};
  std::array<std::optional<Element>, 4> found;
  TraceStep step;
  const Path path;
  if (!json::fields(root, kWanted, found, path, faults)) return step;
  Line line(path, faults);
  step.scan = line.string(*found[0], "s");
  step.config = line.string(*found[1], "c");
  if (!header.configs.contains(step.config)) {
    faults.error(Path(path, "c"), "unknown-config",
                 fmt::format("{:?} is not one of the header's configs", step.config));
  }
  step.action = read_action(*found[2], Path(path, "a"), faults);
  step.state = read_state(*found[3], Path(path, "st"), faults);
  return step;
}

struct CloseGz {
  void operator()(gzFile_s* file) const { gzclose(file); }
};

}  // namespace

// The lines of a file; zlib passes on as it stands what is not compressed.
class TraceReader::Lines {
 public:
  explicit Lines(const std::filesystem::path& path) : path_(path.string()) {
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored)) fail("is a folder");
    file_.reset(gzopen(path_.c_str(), "rb"));
    if (!file_) fail(std::generic_category().message(errno));
    gzbuffer(file_.get(), 1U << 17U);
  }

  // The next line that is not empty; false at the end.
  bool next(std::string& line) {
    do {
      if (!read_line(line)) return false;
      ++number_;
    } while (line.find_first_not_of(" \t\r") == std::string::npos);
    return true;
  }

  std::size_t number() const noexcept { return number_; }
  std::string name() const { return fmt::format("{}:{}", path_, number_); }

 private:
  bool read_line(std::string& line) {
    line.clear();
    for (;;) {
      if (at_ == end_ && !fill()) return !line.empty();
      const std::string_view rest(buffer_.data() + at_, end_ - at_);
      const std::size_t newline = rest.find('\n');
      line += rest.substr(0, newline);
      at_ += newline == std::string_view::npos ? rest.size() : newline + 1;
      if (newline != std::string_view::npos) return true;
    }
  }

  bool fill() {
    const int got = gzread(file_.get(), buffer_.data(), static_cast<unsigned>(buffer_.size()));
    // At the end of data that was cut short gzread() is content, and gzerror() is not.
    int code = Z_OK;
    const std::string reason = gzerror(file_.get(), &code);
    if (got < 0 || (got == 0 && code != Z_OK)) {
      fail(fmt::format("{} (after line {})",
                       code == Z_ERRNO       ? std::generic_category().message(errno)
                       : code == Z_BUF_ERROR ? "the file ends too early"
                                             : reason,
                       number_));
    }
    at_ = 0;
    end_ = static_cast<std::size_t>(got);
    return got > 0;
  }

  [[noreturn]] void fail(const std::string& reason) const {
    throw FileError(fmt::format("{}: cannot read: {}", path_, reason));
  }

  std::string path_;
  std::unique_ptr<gzFile_s, CloseGz> file_;
  std::array<char, 1U << 16U> buffer_{};
  std::size_t at_ = 0, end_ = 0;
  std::size_t number_ = 0;
};

TraceReader::TraceReader(const std::filesystem::path& path)
    : lines_(std::make_unique<Lines>(path)) {
  std::string line;
  if (!lines_->next(line)) {
    throw InvalidInput({{Severity::kError, path.string(), "", "no-header",
                         "the file is empty; a header line is expected"}});
  }
  const auto document = json::Document::parse(line, lines_->name());
  Faults faults(lines_->name());
  header_ = read_header(document.root(), faults);
  faults.throw_if_errors();
}

TraceReader::~TraceReader() = default;
TraceReader::TraceReader(TraceReader&&) noexcept = default;
TraceReader& TraceReader::operator=(TraceReader&&) noexcept = default;

std::optional<TraceStep> TraceReader::next() {
  std::string line;
  if (!lines_->next(line)) return std::nullopt;
  const auto document = json::Document::parse(line, lines_->name());
  Faults faults(lines_->name());
  TraceStep step = read_step(document.root(), header_, faults);
  faults.throw_if_errors();
  step.line = lines_->number();
  return step;
}

}  // namespace enfilade::tests
