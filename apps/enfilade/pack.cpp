// enfilade pack: a data set's pictures into stores, one file a scan; and stores checked.
#include <fmt/format.h>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <system_error>

#include "apps/common/program.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/scan/connectivity.h"
#include "enfilade/scan/panorama_set.h"
#include "enfilade/scan/store.h"

namespace enfilade::apps::pack_verb {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::vector<std::string> scans, images, check;
  std::string data, connectivity, output;
  std::string colour = "keep";
  bool excluded = false;
  scan::PackOptions options;
};

scan::PackOptions options_of(const Arguments& a) {
  scan::PackOptions options = a.options;
  options.colour = a.colour == "keep"   ? scan::ColourCoding::kKeep
                   : a.colour == "jpeg" ? scan::ColourCoding::kJpeg
                                        : scan::ColourCoding::kRaw;
  options.included_only = !a.excluded;
  return options;
}

scan::PanoramaPlaces places_of(const Arguments& a) {
  scan::PanoramaPlaces places;
  if (a.images.empty()) places = open_data(a.data).panorama_places();
  if (!a.images.empty()) places.images.assign(a.images.begin(), a.images.end());
  if (!a.connectivity.empty()) places.connectivity = a.connectivity;
  if (places.connectivity.empty()) places.connectivity = open_data(a.data).connectivity_folder();
  // The output folder is not read from.
  std::erase_if(places.images, [&](const fs::path& folder) {
    std::error_code ignored;
    return fs::equivalent(folder, a.output, ignored);
  });
  return places;
}

std::string size_text(std::uint64_t bytes) {
  return fmt::format("{:.1f} MB", static_cast<double>(bytes) / 1e6);
}

std::string summary(const scan::PackReport& report, double seconds) {
  if (report.was_complete) {
    return fmt::format("complete already: {}, {}", counted(report.panoramas, "panorama"),
                       size_text(report.bytes));
  }
  const std::string resumed =
      report.resumed == 0
          ? ""
          : fmt::format(" ({} of them kept from a run that was stopped)", report.resumed);
  return fmt::format("{}{} in {:.1f} s, {}", counted(report.panoramas, "panorama"), resumed,
                     seconds, size_text(report.bytes));
}

void list_without(const scan::PackReport& report) {
  if (report.without.empty()) return;
  constexpr std::size_t kShown = 5;
  std::string ids;
  for (std::size_t i = 0; i < std::min(kShown, report.without.size()); ++i) {
    ids += "\n    " + report.without[i];
  }
  if (report.without.size() > kShown) ids += "\n    ...";
  say(stderr, "  {} without pictures:{}\n", counted(report.without.size(), "included viewpoint"),
      ids);
}

struct Outcome {
  std::size_t packed = 0, without = 0, failed = 0;
};

// Packs one scan. Its faults are printed, so that the other scans are still packed.
void pack_scan(const Arguments& a, const scan::PanoramaPlaces& places, const std::string& scan,
               Outcome& outcome) {
  std::shared_ptr<const scan::PanoramaSource> source;
  try {
    try {
      source = scan::open_panoramas(places, scan);
    } catch (const LookupError&) {
      if (!a.scans.empty()) throw;  // it was asked for by name
      ++outcome.without;
      return;
    }
    const Stopwatch watch;
    const scan::PackReport report =
        scan::pack(*source, a.output, options_of(a), progress_bar("packing " + scan));
    say("{}: {}\n", report.file.string(), summary(report, watch.seconds()));
    std::fflush(stdout);
    list_without(report);
    ++outcome.packed;
  } catch (const InvalidInput& error) {
    ++outcome.failed;
    print_diagnostics(error.diagnostics());
    say(stderr, "{}: not packed\n", scan);
  } catch (const Error& error) {
    ++outcome.failed;
    say(stderr, "{}: not packed: {}\n", scan, error.what());
  }
}

ExitCode pack_all(const Arguments& a) {
  const scan::PanoramaPlaces places = places_of(a);
  const std::vector<std::string> scans =
      a.scans.empty() ? scan::load_scan_list(places.connectivity) : a.scans;
  Outcome outcome;
  for (const std::string& scan : scans) pack_scan(a, places, scan, outcome);
  if (outcome.packed + outcome.failed == 0) {
    std::string folders;
    for (const fs::path& folder : places.images) folders += "\n  " + folder.string();
    throw FileError(
        fmt::format("no pictures of any of the {} scans were found in:{}", scans.size(), folders));
  }
  if (scans.size() > 1) {
    say("{} scans packed, {} failed, {} have no pictures\n", outcome.packed, outcome.failed,
        outcome.without);
  }
  return outcome.failed > 0 ? kInput : kSuccess;
}

// Prints what is wrong with a store; true if nothing is.
bool check_file(const Arguments& a, const std::string& file) {
  std::vector<Diagnostic> faults;
  try {
    const auto store = scan::Store::open(file);
    faults = store->verify(a.options.threads, progress_bar("checking " + store->scan()));
    if (faults.empty()) {
      say("{}: sound: {} viewpoints, {}\n", file, store->size(), size_text(store->bytes()));
    }
  } catch (const InvalidInput& error) {
    faults = error.diagnostics();
  }
  if (!faults.empty()) print_diagnostics(faults);
  return faults.empty();
}

ExitCode run(const Arguments& a) {
  if (!a.check.empty()) {
    if (!a.scans.empty() || !a.output.empty()) {
      throw UsageError("--check takes store files only, no SCAN and no --output");
    }
    bool sound = true;
    for (const std::string& file : a.check) sound = check_file(a, file) && sound;
    return sound ? kSuccess : kFaultsFound;
  }
  if (a.output.empty()) throw UsageError("pack: where to? Give -o STORE_DIR");
  return pack_all(a);
}

}  // namespace

void add(CLI::App& app, int& status) {
  CLI::App& verb = *app.add_subcommand("pack", "Pack panoramas into stores, one file per scan");
  const auto arguments = std::make_shared<Arguments>();
  add_value(verb, "scans", arguments->scans, "SCAN...",
            "Scans to pack (default: all of scans.txt that have pictures)");
  add_data_option(verb, arguments->data);
  verb.add_option("--images", arguments->images,
                  "Folder of Matterport3D's files or zips; may be repeated (default: store, scans, "
                  "v1/scans, data/v1/scans of the data set)")
      ->allow_extra_args(false)  // else a SCAN behind it would be taken for another
      ->type_name("DIR");
  add_value(verb, "--connectivity", arguments->connectivity, "DIR",
            "Folder of <scan>_connectivity.json (default: that of the data set)");
  add_value(verb, "-o,--output", arguments->output, "STORE_DIR",
            "Folder for the stores; made if missing");
  verb.add_option("--colour", arguments->colour,
                  "keep (the files' JPEGs), jpeg (encoded anew) or raw (decodes fastest)")
      ->check(CLI::IsMember({"keep", "jpeg", "raw"}))
      ->capture_default_str()
      ->type_name("");
  verb.add_flag("--decoded", arguments->options.decoded,
                "Store layers decoded: drawn without decoding, ten times as large");
  add_whole_number(verb, "--face-size", arguments->options.face_size,
                   "Shrink larger faces to this edge, texels; 0: as they are", 0);
  add_setting(verb, "--quality", arguments->options.jpeg_quality, "",
              "JPEG quality, 1 to 100; full chroma from 90 on", CLI::Range(1, 100));
  verb.add_flag("--excluded", arguments->excluded, "Pack viewpoints that the graph excludes, too");
  add_threads_option(verb, arguments->options.threads);
  add_value(verb, "--check", arguments->check, "FILE...",
            "Only check these stores, by all checksums");
  set_examples(
      verb,
      {"enfilade pack -o data/store",
       "enfilade pack 17DRP5sb8fy --images v1/scans --connectivity connectivity -o store",
       "enfilade pack --face-size 256 --colour jpeg --quality 90 -o small",
       "enfilade pack 17DRP5sb8fy --decoded -o decoded", "enfilade pack --check store/*.enfilade"},
      "An interrupted run resumes; complete stores stay.\nExit code 3 if a scan could not be "
      "packed, 1 if --check finds faults.");
  verb.callback([arguments, &status] { status = run(*arguments); });
}

}  // namespace enfilade::apps::pack_verb
