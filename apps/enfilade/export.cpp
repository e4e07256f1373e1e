// enfilade export: files that other code reads, made of any data set.
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <system_error>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/mesh_files.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/agents/continuous_setup.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/core/threads.h"
#include "enfilade/exports/box_files.h"
#include "enfilade/exports/expert_walks.h"
#include "enfilade/exports/feature_files.h"
#include "enfilade/exports/graph_tables.h"
#include "enfilade/exports/picture_files.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::apps::export_verb {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string as, output, data, connectivity;
  std::vector<std::string> images, scans;
  std::string features, logits, type = "f32", boxes, meshes;
  std::size_t most_objects = exports::kMostObjects;
  bool nested = false;
  std::string task = "r2r-ce", split = "train", appearance = "mesh", python = "python3";
  std::string lerobot_version = "3.0";
  bool videos = false;
  int quality = exports::ViewPicturesOptions().quality;
  int threads = 0;
};

/// One form: its name, the file that public code looks for, or none if there are several.
struct Form {
  const char* name;
  const char* file;
  const char* about;
  void (*write)(const Options& options, const dataset::Dataset& data, const fs::path& to);
};

void say_written(const fs::path& file) {
  say("{}: {:.1f} MB\n", file.string(), static_cast<double>(fs::file_size(file)) / 1e6);
}

void write_text(const fs::path& file, const std::string& text) {
  write_file_atomically(file, text);
  say_written(file);
}

void write_text(const OutputFolder& out, const std::string& name, const std::string& text) {
  out.write(name, text);
  say_written(out.path() / name);
}

exports::ExportOptions told(const Options& options) {
  return {options.threads, progress_bar(options.as)};
}

void write_duet(const Options& options, const dataset::Dataset& data, const fs::path& to) {
  write_text(to, exports::duet_candidates(data.graphs(), told(options)));
}
void write_langnav(const Options& options, const dataset::Dataset& data, const fs::path& to) {
  write_text(to, exports::langnav_adjacency(data.graphs(), told(options)));
}

/// Calls `write` for each scan, in parallel, and shows how far it is.
template <class Write>
void for_each_scan(const Options& options, const graph::GraphSet& graphs, const Write& write) {
  const Progress bar = progress_bar(options.as);
  std::mutex mutex;
  std::size_t done = 0;
  parallel_for(graphs.size(), 1, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      write(ScanIndex(i), graphs.scans()[i]);
      const std::lock_guard lock(mutex);
      if (bar) bar(++done, graphs.size());
    }
  });
}

void write_navgpt(const Options& options, const dataset::Dataset& data, const fs::path& to) {
  const OutputFolder out(to);
  const auto& graphs = data.graphs();
  for_each_scan(options, *graphs, [&](ScanIndex scan, const std::string& name) {
    out.write(name + "_navigable.json", exports::navgpt_navigable(graphs, scan));
  });
  say("{}: {} files\n", to.string(), graphs->size());
}

/// A form's half in Python: modules that it imports, and pip's extra of enfilade that brings them.
struct PythonHalf {
  const char* modules;
  const char* extra;
};

/// Arguments of a Python that runs enfilade.exports.main(). Without arguments for that, it only
/// imports the modules.
std::vector<std::string> python_words(const Options& options, const PythonHalf& half) {
  return {options.python, "-c",
          fmt::format("import sys\n"
                      "try:\n"
                      "    import {}\n"
                      "    from enfilade.exports import main\n"
                      "except ImportError as error:\n"
                      "    print(f'export: {{sys.executable}}: {{error}}: "
                      "pip install \"enfilade[{}]\", or --python PROGRAM', file=sys.stderr)\n"
                      "    sys.exit(2)\n"
                      "sys.exit(main() if len(sys.argv) > 1 else 0)\n",
                      half.modules, half.extra)};
}

UsageError not_started(const Options& options, int error) {
  return UsageError(
      fmt::format("export: {}: {}; --python names another", options.python, std::strerror(error)));
}

/// Imports the modules in a Python of its own, which prints the missing one. \throws UsageError
void check_python(const Options& options, const PythonHalf& half) {
  const int status = run_command(python_words(options, half));
  if (status < 0) throw not_started(options, -status);
  if (status != 0) {
    throw UsageError(fmt::format(
        "export --as {}: Python writes the files; nothing is written without it", options.as));
  }
}

/// Becomes Python, for the files that its packages write: the program ends with it.
void continue_in_python(const Options& options, const PythonHalf& half,
                        const std::vector<std::string>& arguments) {
  std::vector<std::string> words = python_words(options, half);
  words.insert(words.end(), arguments.begin(), arguments.end());
  throw not_started(options, become(options.python, words));
}

void write_networkx(const Options& options, const dataset::Dataset& data, const fs::path& to) {
  constexpr PythonHalf kHalf{"networkx", "graphs"};
  check_python(options, kHalf);
  const OutputFolder out(to);
  const std::string parts = "connectivity_graphs.parts";  // Python removes it
  out.remove_all(parts);                                  // of a run that was stopped
  for (const std::string& folder : {std::string("distances"), std::string("paths"), parts}) {
    static_cast<void>(out.folder(folder));
  }
  const auto& graphs = data.graphs();
  for_each_scan(options, *graphs, [&](ScanIndex scan, const std::string& name) {
    const graph::NavGraph& graph = graphs->graph(scan);
    out.write("distances/" + name + ".json", exports::all_distances(graph));
    out.write("paths/" + name + ".json", exports::all_paths(graph));
    out.write(parts + "/" + name + ".json", exports::all_edges(graph));
  });
  say("{}, {}: {} files each\n", (to / "distances").string(), (to / "paths").string(),
      graphs->size());
  continue_in_python(options, kHalf, {"networkx", to.string()});
}

exports::FeatureSource feature_source(const Options& options) {
  if (options.features.empty()) {
    throw UsageError(fmt::format(
        "export --as {}: give --features FILE, the features of the views; enfilade features makes "
        "such a file",
        options.as));
  }
  const auto type = options.type == "f16"   ? features::Hdf5Type::kFloat16
                    : options.type == "f64" ? features::Hdf5Type::kFloat64
                                            : features::Hdf5Type::kFloat32;
  return {options.features, options.logits, type};
}

void write_features(const Options& options, const dataset::Dataset& data, const fs::path& to) {
  exports::write_view_features(data.graphs(), feature_source(options), to, told(options));
  say_written(to);
}

/// From --boxes, --meshes, or the data set.
tasks::ObjectBoxes find_boxes(const Options& options, const dataset::Dataset& data) {
  if (!options.meshes.empty()) {
    std::vector<Diagnostic> warnings;
    auto boxes = exports::boxes_of_meshes(*data.graphs(), data.connectivity_folder(),
                                          options.meshes, {}, told(options), &warnings);
    if (!warnings.empty()) print_diagnostics(warnings);
    return boxes;
  }
  if (!options.boxes.empty()) {
    return exports::boxes_of_graphs(tasks::ObjectBoxes::load(options.boxes), *data.graphs());
  }
  return exports::boxes_of_graphs(data.objects(), *data.graphs());
}

void write_objects(const Options& options, const dataset::Dataset& data, const fs::path& to) {
  const exports::FeatureSource source = feature_source(options);
  exports::write_object_features(data.graphs(), find_boxes(options, data), source, to,
                                 options.most_objects, told(options));
  say_written(to);
}

void write_boxes(const Options& options, const dataset::Dataset& data, const fs::path& to) {
  const bool one_file = to.extension() == ".json" && !fs::is_directory(to);
  if (options.nested && !one_file) {
    throw UsageError("--nested: for one file; let the name of -o end in .json");
  }
  const tasks::ObjectBoxes boxes = find_boxes(options, data);
  if (one_file) {
    write_text(to, boxes.to_json(options.nested));
  } else {
    exports::write_box_folder(boxes, to);
  }
  const tasks::ObjectBoxes::Counts counts = boxes.count();
  say("{}: {} viewpoints, {} objects around them, {} boxes\n", to.string(), counts.viewpoints,
      counts.objects, counts.boxes);
}

/// The file of tokens, if --features names some.
void write_token_file(const Options& options, const dataset::Dataset& data,
                      const exports::TokenShape& shape, const OutputFolder& out,
                      const std::string& name) {
  if (options.features.empty()) {
    say("no {}: give --features FILE with the tokens\n", name);
    return;
  }
  const fs::path file = out.file(name);
  exports::write_tokens(data.graphs(), options.features, shape, file, told(options));
  say_written(file);
}

void write_gridmm(const Options& options, const dataset::Dataset& data, const fs::path& to) {
  const OutputFolder out(to);
  write_text(out, "viewpoint_info.json", exports::gridmm_viewpoints(data.graphs(), told(options)));
  exports::write_gridmm_depth(data, out.file("depth.hdf5"), told(options));
  say_written(to / "depth.hdf5");
  write_token_file(options, data, exports::gridmm_tokens(), out, "clip_p32.hdf5");
}

void write_bevbert(const Options& options, const dataset::Dataset& data, const fs::path& to) {
  const OutputFolder out(to);
  exports::write_bevbert_depth(data, out.file("depth_14x14.hdf5"), told(options));
  say_written(to / "depth_14x14.hdf5");
  exports::write_bevbert_classes(data, out.file("semantic41_14x14.hdf5"), told(options));
  say_written(to / "semantic41_14x14.hdf5");
  write_token_file(options, data, exports::bevbert_tokens(), out, "vit_b16_224_clip_patch.hdf5");
}

void write_views(const Options& options, const dataset::Dataset& data, const fs::path& to) {
  const exports::ViewPicturesReport report =
      exports::write_view_pictures(data, to, {.quality = options.quality}, told(options));
  say("{}: 36 pictures of {} viewpoints, of which {} were there\n", to.string(), report.viewpoints,
      report.kept);
}

using WriteWalks = exports::WalkReport (*)(const exports::ExpertWalks&, const fs::path&,
                                           const exports::WalkPictures&,
                                           const exports::ExportOptions&);

/// The experts' walks of a split, drawn in one of the forms.
template <WriteWalks kWrite>
void write_walks(const Options& options, const dataset::Dataset& data, const fs::path& to) {
  const agents::ContinuousSetup& setup = agents::continuous_setup(options.task);
  const tasks::Split split = data.split(*setup.benchmark, options.split, {.experts = false});
  const tasks::ContinuousEpisodes& episodes = *split.continuous();
  const auto buildings = agents::open_buildings(*setup.benchmark, data.folder());
  exports::WalkPictures pictures;
  pictures.quality = options.quality;
  pictures.data = setup.benchmark->form == tasks::ContinuousForm::kRxr ? "rxr" : "r2r";
  pictures.appearance = find_enum<continuous::Appearance>(options.appearance).value();
  const auto look_of = [&](const std::string& scan) {
    return look_of_scan(data, {.folder = options.meshes}, scan, pictures.appearance,
                        options.threads);
  };
  const exports::WalkReport report =
      kWrite({episodes, buildings, setup.simulator, look_of}, to, pictures, told(options));
  say("{}: {} walks with {} pictures, of which {} walks were there; {} are too long\n", to.string(),
      report.episodes, report.pictures, report.kept, report.too_long);
  if (data.synthetic()) say("SYNTHETIC: model homes made by Enfilade.\n");
}

void write_lerobot(const Options& options, const dataset::Dataset& data, const fs::path& to) {
  const bool old = options.lerobot_version == "2.1";
  if (options.videos && old) throw UsageError("--videos: only with --lerobot-version 3.0");
  // Both versions have these names in their first folder.
  const fs::path other =
      to / "data" / "chunk-000" / (old ? "file-000.parquet" : "episode_000000.parquet");
  if (file_exists(other)) {
    throw UsageError(
        fmt::format("{}: a table of LeRobot {}; take another folder, or "
                    "--lerobot-version {}",
                    other.string(), old ? "3.0" : "2.1", old ? "3.0" : "2.1"));
  }
  const PythonHalf half = options.videos ? PythonHalf{"av, pyarrow.parquet", "lerobot-videos"}
                                         : PythonHalf{"pyarrow.parquet", "lerobot"};
  check_python(options, half);
  write_walks<exports::write_lerobot_parts>(options, data, to);
  std::vector<std::string> arguments{"lerobot", to.string(), "--version", options.lerobot_version};
  if (options.videos) arguments.emplace_back("--videos");
  continue_in_python(options, half, arguments);
}

/// Episodes and experts' walks where VLN-CE's code looks for them.
void write_vlnce(const Options& options, const dataset::Dataset& data, const fs::path& to) {
  const agents::ContinuousSetup& setup = agents::continuous_setup(options.task);
  const tasks::Split split = data.split(*setup.benchmark, options.split);
  // The second folder of each is where the newest public code looks; a place is packed, then plain.
  const auto write = [&](const std::vector<fs::path>& places, const std::string& text) {
    const OutputFolder out(to);
    out.remove_unfinished(places.at(2).parent_path().string(), ".json.gz");
    write_text(out, places.at(2).string(), gzip(text, 6));
  };
  write(tasks::episode_places(*setup.benchmark, options.split), to_json(*split.continuous()));
  if (!split.experts()->empty()) {
    write(tasks::expert_places(*setup.benchmark, options.split), to_json(*split.experts()));
  }
}

constexpr std::array<Form, 14> kForms{{
    {"duet-candidates", "scanvp_candview_relangles.json",
     "neighbours and the view that shows each best (DUET, BEVBert, GridMM)", write_duet},
    {"langnav", "adj_loc_dict.json", "the same with EnvDrop's fields (LangNav, NavCoT)",
     write_langnav},
    {"navgpt", nullptr, "SCAN_navigable.json: neighbours with world angles (NavGPT)", write_navgpt},
    {"networkx", nullptr,
     "distances/, paths/ of all pairs, and connectivity_graphs.pkl (VLN-CE, LANA)", write_networkx},
    {"duet-hdf5", "views.hdf5", "features of the 36 views: (36, D) (HAMT, DUET and descendants)",
     write_features},
    {"object-hdf5", "objects.hdf5", "features of objects: (n, D) (REVERIE in HAMT and DUET)",
     write_objects},
    {"reverie-boxes", nullptr,
     "SCAN_VIEWPOINT.json, boxes of objects; or one file, if -o ends in .json (REVERIE)",
     write_boxes},
    {"bevbert-grid", nullptr,
     "depth_14x14.hdf5, semantic41_14x14.hdf5, vit_b16_224_clip_patch.hdf5 (BEVBert)",
     write_bevbert},
    {"gridmm", nullptr, "viewpoint_info.json, depth.hdf5, clip_p32.hdf5 (GridMM)", write_gridmm},
    {"streamvln", nullptr,
     "images/SCAN_r2r_ID/rgb/001.jpg, annotations.json: continuous expert trajectories "
     "(StreamVLN)",
     write_walks<exports::write_streamvln>},
    {"navila", nullptr,
     "R2R/train/ID/frame_0.jpg, R2R/annotations.json: the same, a decision per up to three "
     "actions (NaVILA)",
     write_walks<exports::write_navila>},
    {"lerobot", nullptr,
     "data/chunk-000/*.parquet, meta/: the same, as a data set of LeRobot 3.0 or 2.1",
     write_lerobot},
    {"vlnce", nullptr,
     "R2R_VLNCE_v1-3_preprocessed/SPLIT/SPLIT.json.gz, SPLIT_gt.json.gz: episodes and expert "
     "trajectories (VLN-CE)",
     write_vlnce},
    {"mapgpt-views", nullptr, "SCAN/VIEWPOINT/0.jpg to 35.jpg (MapGPT)", write_views},
}};

/// A file for a form that is one file: -o itself if its suffix is the form's, else of the usual
/// name in that folder. Else the folder.
fs::path target(const Form& form, const fs::path& output) {
  if (form.file == nullptr) return output;
  const fs::path usual(form.file);
  const bool file = output.extension() == usual.extension() ||
                    (usual.extension() == ".hdf5" && output.extension() == ".h5");
  if (file && !fs::is_directory(output)) return output;
  return OutputFolder(output).file(form.file);
}

/// Removes what killed exports left. Only of files that they write: others may use the folder too.
void remove_left(const fs::path& to) {
  std::error_code unknown;
  if (!fs::is_directory(to, unknown)) {
    return remove_unfinished(to.parent_path(), to.filename().string());
  }
  const OutputFolder out(to);
  for (const char* folder : {"", "distances", "paths", "enfilade_export.parts", "R2R", "RxR"}) {
    out.remove_unfinished(folder, ".json");
  }
  out.remove_unfinished("", "enfilade_views.txt");
}

dataset::Dataset open_source(const Options& options) {
  dataset::DatasetConfig config;
  const bool enough = !options.connectivity.empty();
  if (!options.data.empty() || !enough) config.folder = open_data(options.data).folder();
  config.connectivity = options.connectivity;
  config.images.assign(options.images.begin(), options.images.end());
  config.scans = options.scans;
  return dataset::Dataset(std::move(config));
}

void write_form(const Options& options) {
  const Form& form = *std::ranges::find(kForms, options.as, &Form::name);  // --as has one of them
  const dataset::Dataset data = open_source(options);
  const fs::path to = target(form, options.output);
  remove_left(to);
  form.write(options, data, to);
}

std::string list_of_forms() {
  std::string text = "Forms:";
  for (const Form& form : kForms) text += fmt::format("\n  {:<18}{}", form.name, form.about);
  return text;
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand("export", "Write the files that other projects read");
  const auto options = std::make_shared<Options>();
  std::vector<std::string> names;
  for (const Form& form : kForms) names.emplace_back(form.name);
  add_value(verb, "--as", options->as, "FORM", "Format of the files; the list is below")
      ->required()
      ->check(CLI::IsMember(names));
  add_value(verb, "-o,--output", options->output, "DIR|FILE",
            "Folder, or the file for forms of one file")
      ->required();
  add_data_option(verb, options->data);
  add_value(verb, "--connectivity", options->connectivity, "DIR",
            "Navigation graphs, instead of the data set's");
  add_value(verb, "--images", options->images, "DIR",
            "Folder of panoramas, instead of the data set's; may be repeated");
  add_value(verb, "--scans", options->scans, "SCAN...", "Scans to write (default: all)");
  add_threads_option(verb, options->threads);
  add_value(verb, "--features", options->features, "FILE",
            "Features (duet-hdf5, object-hdf5) or tokens (bevbert-grid, gridmm) of the views");
  add_value(verb, "--logits", options->logits, "FILE",
            "Class scores of the views, appended as columns: for pretraining");
  add_setting(verb, "--type", options->type, "TYPE",
              "Type of features: f16, f32, or f64, as published",
              CLI::IsMember({"f16", "f32", "f64"}));
  CLI::Option* boxes = add_value(verb, "--boxes", options->boxes, "FILE|DIR",
                                 "Boxes of objects, instead of the data set's");
  add_value(verb, "--meshes", options->meshes, "DIR",
            "Labelled meshes for boxes; streamvln, navila, lerobot: meshes to draw")
      ->excludes(boxes);
  add_whole_number(verb, "--objects", options->most_objects,
                   "Most objects per viewpoint (object-hdf5)");
  verb.add_flag("--nested", options->nested,
                "One file of boxes in REVERIE's form, not DUET's (reverie-boxes)");
  add_setting(verb, "--quality", options->quality, "N",
              "JPEG quality, 1 to 100 (mapgpt-views and trajectories)", whole_number(1, 100));
  add_setting(verb, "--task", options->task, "NAME",
              "Benchmark of trajectories (streamvln, navila, lerobot, vlnce)",
              CLI::IsMember({"r2r-ce", "rxr-ce"}));
  add_setting(verb, "--split", options->split, "NAME",
              "Split of trajectories (streamvln, navila, lerobot, vlnce)");
  add_appearance_option(verb, options->appearance);
  add_setting(verb, "--lerobot-version", options->lerobot_version, "N",
              "Version of LeRobot's format: 3.0, or 2.1 with a table per episode",
              CLI::IsMember({"3.0", "2.1"}));
  verb.add_flag("--videos", options->videos, "AV1 videos instead of pictures (lerobot 3.0)");
  add_setting(verb, "--python", options->python, "PROGRAM",
              "A Python with enfilade and networkx (networkx) or pyarrow (lerobot)");
  set_examples(verb, {"enfilade export --as duet-candidates -o datasets/R2R/annotations",
                      "enfilade export --as navgpt --data homes -o navigable",
                      "enfilade export --as duet-hdf5 --features f.safetensors --type f64 -o "
                      "pth_vit_base_patch16_224_imagenet.hdf5",
                      "enfilade export --as reverie-boxes --meshes v1/scans -o BBoxes.json",
                      "enfilade export --as streamvln --data homes --split train -o streamvln",
                      "enfilade export --as lerobot --data homes --split train -o lerobot",
                      "enfilade export --as mapgpt-views --scans 17DRP5sb8fy -o RGB_Observations"});
  verb.footer(list_of_forms() + "\n\n" + verb.get_footer());
  verb.callback([options] { write_form(*options); });
}

}  // namespace enfilade::apps::export_verb
