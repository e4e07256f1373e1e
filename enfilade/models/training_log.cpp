#include "enfilade/models/training_log.h"

#include <fmt/format.h>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "enfilade/core/detail/json.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/models/detail/event_file.h"

namespace enfilade::models {
namespace {

namespace fs = std::filesystem;
using json::Element;
using json::Path;
using Json = nlohmann::ordered_json;

// To a tenth of a millisecond: more digits are noise.
double rounded(double seconds) { return std::round(seconds * 1e4) / 1e4; }

// Seconds since 1970.
double now() {
  const auto since = std::chrono::system_clock::now().time_since_epoch();
  return rounded(std::chrono::duration<double>(since).count());
}

template <class Record>
struct NumberField {
  const char* name;
  double Record::*value;
  bool required = false;
};

// How an evaluation is written.
template <class Record>
struct Form;
template <>
struct Form<EvaluationRecord> {
  static constexpr const char *kType = "evaluation", *kCountName = "episodes";
  static constexpr auto kCount = &EvaluationRecord::episodes;
  static constexpr std::array<NumberField<EvaluationRecord>, 6> kNumbers{
      {{"loss", &EvaluationRecord::loss},
       {"trajectory_length", &EvaluationRecord::trajectory_length},
       {"nav_error", &EvaluationRecord::nav_error, true},
       {"success_rate", &EvaluationRecord::success_rate, true},
       {"oracle_success_rate", &EvaluationRecord::oracle_success_rate},
       {"spl", &EvaluationRecord::spl}}};
};
template <>
struct Form<SpeakerRecord> {
  static constexpr const char *kType = "speaker", *kCountName = "instructions";
  static constexpr auto kCount = &SpeakerRecord::instructions;
  static constexpr std::array<NumberField<SpeakerRecord>, 4> kNumbers{
      {{"loss", &SpeakerRecord::loss},
       {"perplexity", &SpeakerRecord::perplexity},
       {"accuracy", &SpeakerRecord::accuracy},
       {"bleu", &SpeakerRecord::bleu}}};
};

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

// One line of a log.
class Line {
 public:
  Line(std::string_view text, const std::string& name)
      : document_(json::Document::parse(text, name)), faults_(name) {
    type_ = this->text("type");
  }

  const std::string& type() const { return type_; }
  void throw_if_errors() { faults_.throw_if_errors(); }

  // Nothing where it is not there or null.
  std::optional<double> number(const char* name, bool required) {
    const auto found = field(name, required);
    if (!found || (!required && found->is_null())) return std::nullopt;
    return json::number(*found, Path(root_, name), faults_);
  }
  std::uint64_t whole(const char* name, bool required = true) {
    const auto found = field(name, required);
    const auto value = found ? json::integer(*found, Path(root_, name), faults_) : std::nullopt;
    return static_cast<std::uint64_t>(value.value_or(0));
  }
  std::string text(const char* name) {
    const auto found = field(name, true);
    return found ? std::string(json::string(*found, Path(root_, name), faults_).value_or("")) : "";
  }

 private:
  std::optional<Element> field(const char* name, bool required) {
    return json::field(document_.root(), {name, required}, root_, faults_);
  }

  json::Document document_;
  json::Faults faults_;
  Path root_;
  std::string type_;
};

TrainRecord read_training(Line& line) {
  return {line.whole("iteration"), line.number("loss", true).value_or(0),
          line.number("seconds", false).value_or(0), line.number("time", false).value_or(0)};
}

template <class Record>
Record read_evaluation(Line& line) {
  Record record;
  record.iteration = line.whole("iteration");
  record.split = line.text("split");
  record.*Form<Record>::kCount =
      static_cast<std::size_t>(line.whole(Form<Record>::kCountName, false));
  for (const NumberField<Record>& field : Form<Record>::kNumbers) {
    record.*field.value = line.number(field.name, field.required).value_or(kMissing);
  }
  record.time = line.number("time", false).value_or(0);
  return record;
}

void add(TrainingHistory& history, const TrainRecord& record) {
  const auto drop_from = [&record](auto& records) {
    while (!records.empty() && records.back().iteration >= record.iteration) records.pop_back();
  };
  drop_from(history.training);
  drop_from(history.evaluations);
  drop_from(history.speaker);
  history.training.push_back(record);
}

// Adds a line, if it is an evaluation of that kind; those of its split that it comes again for go.
template <class Record>
void add_evaluation(Line& line, std::vector<Record>& records) {
  if (line.type() != Form<Record>::kType) return;
  auto record = read_evaluation<Record>(line);
  std::erase_if(records, [&record](const Record& old) {
    return old.split == record.split && old.iteration >= record.iteration;
  });
  records.push_back(std::move(record));
}

// Calls visit(line, text) for each whole line that is not empty.
template <class Visit>
void for_each_line(std::string_view lines, const std::string& file, const Visit& visit) {
  std::size_t number = 0;
  for (std::size_t end = lines.find('\n'); end != std::string_view::npos; end = lines.find('\n')) {
    const std::string_view text = lines.substr(0, end);
    lines.remove_prefix(end + 1);
    ++number;
    if (text.empty()) continue;
    Line line(text, fmt::format("{}, line {}", file, number));
    visit(line, text);
    line.throw_if_errors();
  }
}

// Cuts off the lines of a log that are beyond `iteration`, and a last one without its end.
void cut(const fs::path& log, std::uint64_t iteration) {
  const std::string text = read_file(log);
  std::string kept;
  for_each_line(text, log.string(), [&](Line& line, std::string_view line_text) {
    if (line.whole("iteration") <= iteration) kept.append(line_text).append("\n");
  });
  if (kept.size() != text.size()) {
    OutputFolder(log.parent_path()).write(log.filename().string(), kept);
  }
}

detail::EventFile new_events(const fs::path& folder) {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    if (!entry.path().filename().string().starts_with(detail::EventFile::kPrefix)) continue;
    fs::remove(entry.path(), ignored);
  }
  return {folder, now()};
}

}  // namespace

double TrainingHistory::seconds() const noexcept {
  double sum = 0;
  for (const TrainRecord& record : training) sum += record.seconds;
  return sum;
}

TrainingHistory parse_training_log(std::string_view lines, const std::string& file) {
  TrainingHistory history;
  for_each_line(lines, file, [&history](Line& line, std::string_view /*text*/) {
    if (line.type() == "train") add(history, read_training(line));
    add_evaluation(line, history.evaluations);
    add_evaluation(line, history.speaker);
  });
  return history;
}

TrainingHistory load_training_log(const fs::path& file) {
  return parse_training_log(read_file(file), file.string());
}

struct TrainingLog::Impl {
  Impl(const fs::path& log, const TrainingHistory& before)
      : lines(log), events(new_events(log.parent_path())) {
    for (const TrainRecord& record : before.training) show(record);
    for (const EvaluationRecord& record : before.evaluations) show(record);
    for (const SpeakerRecord& record : before.speaker) show(record);
  }

  void show(const TrainRecord& record) {
    events.add({"train/loss", record.loss, record.iteration, record.time});
  }
  template <class Record>
  void show(const Record& record) {
    for (const NumberField<Record>& field : Form<Record>::kNumbers) {
      const std::string tag = fmt::format("{}/{}", record.split, field.name);
      events.add({tag, record.*field.value, record.iteration, record.time});
    }
  }
  template <class Record>
  void add(Record record) {
    record.time = now();
    Json line{
        {"type", Form<Record>::kType}, {"iteration", record.iteration}, {"split", record.split}};
    for (const NumberField<Record>& field : Form<Record>::kNumbers) {
      line[field.name] = record.*field.value;
    }
    line[Form<Record>::kCountName] = record.*Form<Record>::kCount;
    line["time"] = record.time;
    write(line);
    show(record);
  }
  void write(const Json& line) { lines.write(line.dump() + "\n"); }

  detail::AppendFile lines;
  detail::EventFile events;
};

TrainingLog::TrainingLog(const fs::path& log, std::uint64_t iteration) {
  std::error_code ignored;
  TrainingHistory before;
  if (fs::exists(log, ignored)) {
    cut(log, iteration);
    before = load_training_log(log);
  }
  impl_ = std::make_unique<Impl>(log, before);
}
TrainingLog::~TrainingLog() = default;

void TrainingLog::start(const std::string& config, std::uint64_t iteration) {
  impl_->write({{"type", "start"},
                {"time", now()},
                {"iteration", iteration},
                {"config", Json::parse(config)}});
}

void TrainingLog::add(TrainRecord record) {
  record.time = now();
  impl_->write({{"type", "train"},
                {"iteration", record.iteration},
                {"loss", record.loss},
                {"seconds", rounded(record.seconds)},
                {"time", record.time}});
  impl_->show(record);
}

void TrainingLog::add(EvaluationRecord record) { impl_->add(std::move(record)); }
void TrainingLog::add(SpeakerRecord record) { impl_->add(std::move(record)); }

}  // namespace enfilade::models
