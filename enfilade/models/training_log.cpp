#include "enfilade/models/training_log.h"

#include <fmt/format.h>
#include <array>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>
#include <vector>

#include "enfilade/core/detail/json.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/models/detail/append_file.h"
#include "enfilade/models/detail/event_file.h"

namespace enfilade::models {
namespace {

namespace fs = std::filesystem;
using json::Element;
using json::Faults;
using json::Field;
using json::Path;
using Json = nlohmann::ordered_json;

// To a tenth of a millisecond: the digits beyond would say nothing.
double rounded(double seconds) { return std::round(seconds * 1e4) / 1e4; }

// Seconds since 1970.
double now() {
  const auto since = std::chrono::system_clock::now().time_since_epoch();
  return rounded(std::chrono::duration<double>(since).count());
}

struct NumberField {
  const char* name;
  double EvaluationRecord::*value;
};
constexpr std::array<NumberField, 6> kNumbers{
    {{"loss", &EvaluationRecord::loss},
     {"trajectory_length", &EvaluationRecord::trajectory_length},
     {"nav_error", &EvaluationRecord::nav_error},
     {"success_rate", &EvaluationRecord::success_rate},
     {"oracle_success_rate", &EvaluationRecord::oracle_success_rate},
     {"spl", &EvaluationRecord::spl}}};

// What an old log says, with the seconds since 1970 of each line.
struct KeptLog {
  std::vector<std::pair<double, TrainRecord>> train;
  std::vector<std::pair<double, EvaluationRecord>> evaluation;
};

// A log that is read back: which lines stay, and what they say.
class LogReader {
 public:
  LogReader(const fs::path& path, std::uint64_t iteration)
      : faults_(path.string()), iteration_(iteration) {
    std::error_code ignored;
    if (!fs::exists(path, ignored)) return;
    const std::string text = read_file(path);
    std::size_t line = 0;
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = text.find('\n', begin);
      if (end == std::string::npos) break;  // half-written
      read_line(std::string_view(text).substr(begin, end - begin), ++line);
      begin = end + 1;
    }
    faults_.throw_if_errors();
    if (kept_.size() != text.size()) write_file_atomically(path, kept_);
  }

  KeptLog take() { return std::move(records_); }

 private:
  void read_line(std::string_view text, std::size_t number) {
    const auto document =
        json::Document::parse(text, fmt::format("{}, line {}", faults_.file(), number));
    const Path file;
    const Path path(file, number - 1);  // "$[2]": the third line
    const Element root = document.root();
    const auto type = string(root, "type", path);
    const auto iteration = this->number(root, "iteration", path);
    const double time = this->number(root, "time", path);
    if (iteration > static_cast<double>(iteration_)) return;
    kept_.append(text).append("\n");
    if (type == "train") read_train(root, path, time);
    if (type == "evaluation") read_evaluation(root, path, time);
  }

  void read_train(Element root, const Path& path, double time) {
    records_.train.emplace_back(
        time, TrainRecord{whole(root, "iteration", path), number(root, "loss", path),
                          number(root, "seconds", path)});
  }

  void read_evaluation(Element root, const Path& path, double time) {
    EvaluationRecord record;
    record.iteration = whole(root, "iteration", path);
    record.split = string(root, "split", path);
    record.episodes = static_cast<std::size_t>(whole(root, "episodes", path));
    for (const NumberField& field : kNumbers) record.*field.value = number(root, field.name, path);
    records_.evaluation.emplace_back(time, std::move(record));
  }

  std::optional<Element> field(Element root, const char* name, const Path& path) {
    const std::array<Field, 1> wanted{{{name}}};
    std::array<std::optional<Element>, 1> found;
    json::fields(root, wanted, found, path, faults_);
    return found[0];
  }

  double number(Element root, const char* name, const Path& path) {
    const auto found = field(root, name, path);
    return found ? json::number(*found, Path(path, name), faults_).value_or(0) : 0;
  }

  std::uint64_t whole(Element root, const char* name, const Path& path) {
    const auto found = field(root, name, path);
    const auto value = found ? json::integer(*found, Path(path, name), faults_) : std::nullopt;
    return static_cast<std::uint64_t>(value.value_or(0));
  }

  std::string string(Element root, const char* name, const Path& path) {
    const auto found = field(root, name, path);
    return found ? std::string(json::string(*found, Path(path, name), faults_).value_or("")) : "";
  }

  Faults faults_;
  std::uint64_t iteration_;
  std::string kept_;  // lines
  KeptLog records_;
};

void remove_events(const fs::path& folder) {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    if (!entry.path().filename().string().starts_with(detail::EventFile::kPrefix)) continue;
    fs::remove(entry.path(), ignored);
  }
}

detail::EventFile new_events(const fs::path& folder) {
  remove_events(folder);
  return {folder, now()};
}

}  // namespace

struct TrainingLog::Impl {
  Impl(const fs::path& log, const KeptLog& kept)
      : lines(log), events(new_events(log.parent_path())) {
    for (const auto& [time, record] : kept.train) show(record, time);
    for (const auto& [time, record] : kept.evaluation) show(record, time);
  }

  void show(const TrainRecord& record, double time) {
    events.add({"train/loss", record.loss, record.iteration, time});
  }
  void show(const EvaluationRecord& record, double time) {
    for (const NumberField& field : kNumbers) {
      const std::string tag = fmt::format("{}/{}", record.split, field.name);
      events.add({tag, record.*field.value, record.iteration, time});
    }
  }

  detail::AppendFile lines;
  detail::EventFile events;
};

TrainingLog::TrainingLog(const fs::path& log, std::uint64_t iteration)
    : impl_(std::make_unique<Impl>(log, LogReader(log, iteration).take())) {}
TrainingLog::~TrainingLog() = default;

void TrainingLog::start(const std::string& config, std::uint64_t iteration) {
  const Json line{{"type", "start"},
                  {"time", now()},
                  {"iteration", iteration},
                  {"config", Json::parse(config)}};
  impl_->lines.write(line.dump() + "\n");
}

void TrainingLog::add(const TrainRecord& record) {
  const double time = now();
  const Json line{{"type", "train"},
                  {"iteration", record.iteration},
                  {"loss", record.loss},
                  {"seconds", rounded(record.seconds)},
                  {"time", time}};
  impl_->lines.write(line.dump() + "\n");
  impl_->show(record, time);
}

void TrainingLog::add(const EvaluationRecord& record) {
  const double time = now();
  Json line{{"type", "evaluation"}, {"iteration", record.iteration}, {"split", record.split}};
  for (const NumberField& field : kNumbers) line[field.name] = record.*field.value;
  line["episodes"] = record.episodes;
  line["time"] = time;
  impl_->lines.write(line.dump() + "\n");
  impl_->show(record, time);
}

}  // namespace enfilade::models
