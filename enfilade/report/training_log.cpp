#include "enfilade/report/training_log.h"

#include <fmt/format.h>
#include <array>
#include <limits>
#include <optional>
#include <utility>

#include "enfilade/core/detail/json.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"

namespace enfilade::report {
namespace {

using json::Element;
using json::Faults;
using json::Path;

class LogReader {
 public:
  explicit LogReader(const std::string& file) : file_(file) {}

  void read_line(std::string_view text, std::size_t line) {
    const std::string name = fmt::format("{}, line {}", file_, line);
    const json::Document document = json::Document::parse(text, name);
    Faults faults(name);
    const Path root;
    constexpr std::array<json::Field, 1> kWanted{{{"type"}}};
    std::array<std::optional<Element>, 1> found;
    if (json::fields(document.root(), kWanted, found, root, faults)) {
      const auto type = json::string(*found[0], Path(root, "type"), faults);
      if (type == "train") read_training(document.root(), faults);
      if (type == "evaluation") read_evaluation(document.root(), faults);
    }
    faults.throw_if_errors();
  }

  TrainingLog take() {
    for (const double seconds : seconds_) log_.seconds += seconds;
    return std::move(log_);
  }

 private:
  void read_training(Element line, Faults& faults) {
    enum { kIteration, kLoss, kSeconds, kFields };
    constexpr std::array<json::Field, kFields> kWanted{
        {{"iteration"}, {"loss"}, {"seconds", false}}};
    std::array<std::optional<Element>, kFields> found;
    const Path root;
    if (!json::fields(line, kWanted, found, root, faults)) return;
    const auto iteration = json::number(*found[kIteration], Path(root, "iteration"), faults);
    const auto loss = json::number(*found[kLoss], Path(root, "loss"), faults);
    const auto seconds =
        found[kSeconds] ? json::number(*found[kSeconds], Path(root, "seconds"), faults) : 0;
    if (!iteration || !loss) return;
    while (!log_.training.empty() && log_.training.back().iteration >= *iteration) {
      log_.training.pop_back();
      seconds_.pop_back();
    }
    while (!log_.evaluations.empty() && log_.evaluations.back().iteration >= *iteration) {
      log_.evaluations.pop_back();
    }
    log_.training.push_back({*iteration, *loss});
    seconds_.push_back(seconds.value_or(0));
  }

  void read_evaluation(Element line, Faults& faults) {
    enum { kIteration, kSplit, kLoss, kError, kSuccess, kFields };
    constexpr std::array<json::Field, kFields> kWanted{
        {{"iteration"}, {"split"}, {"loss", false}, {"nav_error"}, {"success_rate"}}};
    std::array<std::optional<Element>, kFields> found;
    const Path root;
    if (!json::fields(line, kWanted, found, root, faults)) return;
    const auto number = [&](std::size_t k) {
      return json::number(*found.at(k), Path(root, kWanted.at(k).name), faults).value_or(0);
    };
    EvaluationPoint point;
    point.iteration = number(kIteration);
    point.split = json::string(*found[kSplit], Path(root, "split"), faults).value_or("");
    const bool has_loss = found[kLoss] && !found[kLoss]->is_null();
    point.loss = has_loss ? number(kLoss) : std::numeric_limits<double>::quiet_NaN();
    point.nav_error = number(kError);
    point.success = number(kSuccess);
    std::erase_if(log_.evaluations, [&point](const EvaluationPoint& other) {
      return other.split == point.split && other.iteration >= point.iteration;
    });
    log_.evaluations.push_back(std::move(point));
  }

  std::string file_;
  TrainingLog log_;
  std::vector<double> seconds_;  // of each training point
};

}  // namespace

TrainingLog parse_training_log(std::string_view lines, const std::string& file) {
  LogReader reader(file);
  std::size_t line = 0;
  for (std::size_t end = lines.find('\n'); end != std::string_view::npos; end = lines.find('\n')) {
    ++line;
    const std::string_view text = lines.substr(0, end);
    lines.remove_prefix(end + 1);
    if (!text.empty()) reader.read_line(text, line);
  }
  return reader.take();
}

TrainingLog load_training_log(const std::filesystem::path& file) {
  return parse_training_log(read_file(file), file.string());
}

std::vector<TrainingPoint> thinned(const std::vector<TrainingPoint>& points, std::size_t most) {
  if (most == 0) throw ArgumentError("most: 0, not at least 1");
  const std::size_t each = (points.size() + most - 1) / most;
  if (each <= 1) return points;
  std::vector<TrainingPoint> thin;
  for (std::size_t begin = 0; begin < points.size(); begin += each) {
    const std::size_t end = std::min(begin + each, points.size());
    TrainingPoint mean;
    for (std::size_t i = begin; i < end; ++i) {
      mean.iteration += points[i].iteration / static_cast<double>(end - begin);
      mean.loss += points[i].loss / static_cast<double>(end - begin);
    }
    thin.push_back(mean);
  }
  return thin;
}

}  // namespace enfilade::report
