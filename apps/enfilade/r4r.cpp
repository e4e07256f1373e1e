// enfilade r4r: longer episodes, joined from R2R's.
#include <fmt/format.h>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "apps/common/program.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/core/file.h"
#include "enfilade/core/part_file.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/r4r.h"

namespace enfilade::apps::r4r_verb {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string split, data, annotations, connectivity, output;
  tasks::JoinOptions join;
};

tasks::Annotations load_paths(const Options& options) {
  if (options.split.empty() && options.annotations.empty()) {
    throw UsageError("r4r: which split? Give --split NAME, or --annotations FILE");
  }
  const fs::path file = options.annotations.empty()
                            ? open_data(options.data)
                                  .episodes_file(tasks::benchmark(tasks::Task::kR2r), options.split)
                            : fs::path(options.annotations);
  const std::string split = options.split.empty() ? file.stem().string() : options.split;
  return tasks::load_annotations(file, split, tasks::Task::kR2r);
}

// A file that is whole or not there, whatever ends the program.
class Output {
 public:
  explicit Output(std::string path) : path_(std::move(path)) {
    // Devices and pipes, as standard output, are written as they are.
    whole_ = path_ == "-" || (file_exists(path_) && !fs::is_regular_file(path_));
  }
  ~Output() {
    if (file_ && !finished_) file_->remove();
  }
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;

  void write(std::string_view text) {
    if (path_ == "-") {
      write_output("-", std::string(text));
    } else if (whole_) {
      text_ += text;
    } else {
      if (!file_) {
        file_.emplace(path_);
        file_->resize(0);  // what an earlier run left that was killed
      }
      file_->write_at(size_, std::as_bytes(std::span(text)));
      size_ += text.size();
    }
  }
  void finish() {
    if (file_) file_->finish();
    if (whole_ && path_ != "-") write_output(path_, text_);
    finished_ = true;
  }

 private:
  std::string path_, text_;
  bool whole_ = false, finished_ = false;
  std::optional<PartFile> file_;
  std::uint64_t size_ = 0;
};

void join(const Options& options) {
  const tasks::Annotations paths = load_paths(options);
  const auto graphs = options.connectivity.empty() ? open_data(options.data).graphs()
                                                   : graph::GraphSet::open(options.connectivity);
  Output output(options.output);
  const tasks::JoinTotals totals = tasks::write_joined(
      paths, *graphs, options.join, [&output](std::string_view text) { output.write(text); });
  output.finish();
  if (options.output == "-") return;
  say("{}: {} of {} {} joined, {} instructions, mean length {:.2f} m\n", options.output,
      totals.paths, totals.pairs, options.join.paths == 2 ? "pairs" : "sequences",
      totals.instructions,
      totals.paths == 0 ? 0 : totals.length / static_cast<double>(totals.paths));
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand(
      "r4r", "Join Room-to-Room paths into longer ones: R4R, R6R, R8R, as published");
  const auto options = std::make_shared<Options>();
  add_value(verb, "--split", options->split, "NAME", "train, val_seen, val_unseen");
  add_value(verb, "-o,--output", options->output, "FILE", "File to write, - for standard output")
      ->required();
  add_data_option(verb, options->data);
  add_value(verb, "--annotations", options->annotations, "FILE",
            "Paths to join, in R2R's form, instead of the data set's R2R_<split>.json");
  add_value(verb, "--connectivity", options->connectivity, "DIR",
            "Navigation graphs, instead of the data set's");
  add_setting(verb, "--gap", options->join.most_gap, "METRES",
              "Most metres along the graph from one path to the next", finite_number(0));
  add_setting(verb, "--paths", options->join.paths, "",
              "Paths per joined path: 2 (R4R), 3 (R6R) or 4 (R8R)", whole_number(2, 4));
  set_examples(verb, {"enfilade r4r --split val_unseen -o r4r/R4R_val_unseen.json",
                      "enfilade r4r --split val_seen --paths 3 -o r6r.json"});
  verb.callback([options] { join(*options); });
}

}  // namespace enfilade::apps::r4r_verb
