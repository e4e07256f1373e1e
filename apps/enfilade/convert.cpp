// enfilade convert: the same content in another form.
#include <fmt/format.h>
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "apps/common/program.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/core/gzip.h"
#include "enfilade/exports/box_files.h"
#include "enfilade/exports/convert.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/models/subwords.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::apps::convert_verb {
namespace {

namespace fs = std::filesystem;
using exports::FileKind;

struct Options {
  std::string from, to, form, task, vocabulary;
  bool cased = false;
};

tasks::Task graph_task(const std::string& name) {
  return tasks::benchmark(name, tasks::WorldKind::kGraph).task;
}

/// Packed, if the file's name says so.
void write_maybe_packed(const std::string& to, const std::string& text) {
  constexpr int kLevel = 6;
  write_output(to, fs::path(to).extension() == ".gz" ? gzip(text, kLevel) : text);
}

/// The suffix in front of ".gz".
std::string suffix_of(fs::path file) {
  if (file.extension() == ".gz") file = file.stem();
  return file.extension().string();
}

[[noreturn]] void refuse_form(const Options& options, FileKind kind, const char* allowed) {
  if (options.form.empty()) {
    throw UsageError(fmt::format("{}: give --to {}", to_string(kind), allowed));
  }
  throw UsageError(
      fmt::format("--to {}: {} are converted to {}", options.form, to_string(kind), allowed));
}

std::string convert_annotations(const Options& options) {
  if (!options.form.empty() && options.form != "released" && options.form != "duet") {
    refuse_form(options, FileKind::kAnnotations, "released or duet (SOON), or without --to");
  }
  const std::string text = read_text_file(options.from);
  const std::optional<tasks::Task> task =
      options.task.empty() ? tasks::find_task(text) : std::optional(graph_task(options.task));
  if (!task) throw UsageError(fmt::format("{}: which benchmark? Give --task", options.from));
  if (!options.form.empty() && *task != tasks::Task::kSoon) {
    throw UsageError(fmt::format("--to {}: a form of SOON's annotations; those of {} have one only",
                                 options.form, tasks::benchmark(*task).title));
  }
  tasks::Annotations read =
      tasks::parse_annotations(text, options.from, fs::path(options.from).stem().string(), *task);
  if (!options.vocabulary.empty()) {
    using models::Letters;
    const auto letters = options.cased ? Letters::kAsWritten : Letters::kFolded;
    encode_instructions(read, models::Subwords::load(options.vocabulary, letters));
  }
  write_maybe_packed(options.to,
                     exports::annotations_text(read, {.released = options.form == "released",
                                                      .lines = suffix_of(options.to) == ".jsonl"}));
  return fmt::format("{} paths of {}", read.paths.size(), tasks::benchmark(*task).title);
}

std::string convert_followers(const Options& options) {
  if (!options.form.empty()) refuse_form(options, FileKind::kFollowers, "lines, without --to");
  const auto walks = tasks::load_demonstrations(options.from);
  write_maybe_packed(options.to, tasks::to_text(walks));
  return counted(walks.size(), "walk");
}

std::string convert_results(const Options& options) {
  if (options.form != "official" && options.form != "duet") {
    refuse_form(options, FileKind::kResults, "official or duet");
  }
  const std::string text = read_text_file(options.from);
  const std::optional<tasks::Task> task = options.task.empty()
                                              ? tasks::find_task_of_results(text)
                                              : std::optional(graph_task(options.task));
  if (!task) throw UsageError(fmt::format("{}: which benchmark? Give --task", options.from));
  const auto keys =
      options.form == "official" ? exports::ResultKeys::kOfficial : exports::ResultKeys::kDuet;
  write_maybe_packed(options.to, with_keys(text, options.from, keys, *task));
  return fmt::format("results of {}", tasks::benchmark(*task).title);
}

std::string convert_boxes(const Options& options) {
  const tasks::ObjectBoxes boxes = tasks::ObjectBoxes::load(options.from);
  const bool one_file = options.to == "-" || suffix_of(options.to) == ".json";
  const std::string form = !options.form.empty() ? options.form : one_file ? "flat" : "folder";
  if (form == "folder") {
    if (options.to == "-") throw UsageError("--to folder: not to standard output; name a folder");
    exports::write_box_folder(boxes, options.to);
  } else if (form == "flat" || form == "nested") {
    write_maybe_packed(options.to, boxes.to_json(form == "nested"));
  } else {
    refuse_form(options, FileKind::kBoxes, "flat (DUET), nested or folder (REVERIE)");
  }
  const tasks::ObjectBoxes::Counts counts = boxes.count();
  return fmt::format("{} viewpoints, {} objects, {} boxes", counts.viewpoints, counts.objects,
                     counts.boxes);
}

std::string convert_feature_file(const Options& options) {
  if (!options.form.empty() && options.form != "f16" && options.form != "f32") {
    refuse_form(options, FileKind::kFeatures, "f16 or f32; the format is that of the suffix");
  }
  const std::array<fs::path, 1> from{options.from};
  features::convert_features(
      from, options.to,
      options.form == "f16" ? features::DType::kFloat16 : features::DType::kFloat32);
  return "features";
}

void convert(const Options& options) {
  const FileKind kind = exports::find_kind(options.from);
  if (kind != FileKind::kAnnotations && !options.vocabulary.empty()) {
    throw UsageError(
        fmt::format("--vocabulary: for annotations; {} holds {}", options.from, to_string(kind)));
  }
  constexpr std::array kConverters{convert_annotations, convert_followers, convert_results,
                                   convert_boxes, convert_feature_file};  // by FileKind
  const std::string what = kConverters.at(static_cast<std::size_t>(kind))(options);
  if (options.to != "-") say("{}: {}\n", options.to, what);
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand(
      "convert", "Convert annotations, results, boxes or features to another format");
  const auto options = std::make_shared<Options>();
  add_value(verb, "from", options->from, "FROM", "File, packed or not, or folder of boxes")
      ->required();
  add_value(verb, "output", options->to, "TO",
            "File, .gz packed, .jsonl in lines; - for standard output; or folder")
      ->required();
  add_value(verb, "--to", options->form, "FORM",
            "Format: released, duet, official, flat, nested, folder, f16 or f32 (docs/exports.md)");
  add_value(verb, "--task", options->task, "NAME",
            "Benchmark: r2r, rxr, ... (default: found by the fields)");
  add_value(verb, "--vocabulary", options->vocabulary, "FILE",
            "Add instr_encodings, token ids of BERT's vocab.txt or XLM-R's .model");
  verb.add_flag("--cased", options->cased, "vocab.txt is cased (default: uncased)");
  set_examples(
      verb, {"enfilade convert R2R_train.json R2R_train_enc.json --vocabulary vocab.txt",
             "enfilade convert REVERIE_val_unseen.json.gz val.jsonl",
             "enfilade convert BBox BBoxes.json", "enfilade convert BBoxes.json BBox --to folder",
             "enfilade convert results.json official.json --to official --task reverie",
             "enfilade convert features.tsv features.safetensors --to f16"});
  verb.callback([options] { convert(*options); });
}

}  // namespace enfilade::apps::convert_verb
