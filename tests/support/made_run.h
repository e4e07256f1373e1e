/// \file  A made-up data set and run, for tests: a row of viewpoints 2 m apart, two paths a split.
#pragma once
#include <fmt/format.h>
#include <filesystem>
#include <string>
#include <vector>

#include "enfilade/core/file.h"
#include "enfilade/scan/panorama_source.h"
#include "enfilade/scan/store.h"
#include "enfilade/tasks/annotations.h"
#include "tests/support/graphs.h"
#include "tests/support/panoramas.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::report::testing {

/// `data/` and `run/` of a folder that is gone with this object.
class MadeRun {
 public:
  MadeRun() : folder_("report") {
    make_folder(data() / "connectivity");
    make_folder(data() / "r2r");
    write_file_atomically(data() / "connectivity/scans.txt", "row\n");
    write_file_atomically(data() / "connectivity/row_connectivity.json", to_json(graph()));
    for (const char* split : {"train", "val_seen", "val_unseen"}) write_split(split, false);
    write_split("test", true);
    make_folder(run());
  }
  std::filesystem::path data() const { return folder_.path() / "data"; }
  std::filesystem::path run() const { return folder_.path() / "run"; }

  /// Paths v0 ... v4 and v0 ... v3, with three instructions each.
  void write_split(const std::string& split, bool hidden,
                   const std::string& instruction = "Walk past the sofa and stop.") const {
    tasks::Annotations annotations{split, "", {}};
    for (std::int64_t id = 1; id <= 2; ++id) {
      tasks::PathAnnotation path{id, "row", Radians(1.5), {"v0", "v1", "v2", "v3", "v4"}, 8.0, {}};
      if (id == 2) path.path.pop_back();
      if (id == 2) path.distance = 6;
      if (hidden) path.path.resize(1);
      if (hidden) path.distance.reset();
      path.instructions = {instruction, "Go straight on.", "Turn left and wait by the door."};
      annotations.paths.push_back(std::move(path));
    }
    write_file_atomically(data() / fmt::format("r2r/R2R_{}.json", split), to_json(annotations));
  }

  /// Pictures of every viewpoint, packed.
  void write_pictures() const {
    std::vector<scan::Panorama> panoramas;
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      panoramas.push_back(scan::testing::panorama(32, seed));
    }
    make_folder(data() / "store");
    pack(scan::MemoryPanoramas(graph(), std::move(panoramas)), data() / "store", {});
  }

  /// What training leaves behind, in the documented layout: TEST DATA, made by a formula.
  void write_model(const std::string& agent, double shift) const {
    const std::filesystem::path folder = run() / "models" / agent;
    make_folder(folder / "results");
    write_file_atomically(folder / "config.json",
                          R"({"feedback": "sample", "sizes": {"hidden": 8}})");
    std::string log = "{\"type\": \"start\", \"time\": 0, \"config\": {}}\n";
    for (int i = 1; i <= 60; ++i) {
      const double x = i / 60.0;
      log += fmt::format(R"({{"type": "train", "iteration": {}, "loss": {}, "seconds": 0.1}})"
                         "\n",
                         i, 1.2 - 0.7 * x + shift);
      if (i % 10 != 0) continue;
      for (const char* split : {"val_seen", "val_unseen"}) {
        const double worse = split == std::string("val_seen") ? 0 : 0.2 * x;
        log +=
            fmt::format(R"({{"type": "evaluation", "iteration": {}, "split": "{}", "loss": {}, )"
                        R"("nav_error": {}, "success_rate": {}, "episodes": 6}})"
                        "\n",
                        i, split, 1.2 - 0.5 * x + worse, 9 - 3 * x + worse, 0.2 + 0.3 * x - worse);
      }
    }
    write_file_atomically(folder / "log.jsonl", log);
    for (const char* split : {"val_seen", "val_unseen"}) {
      write_results(folder / "results" / fmt::format("{}.json", split), 2);
    }
  }

  /// Attention to the n-th word at the n-th step, for the first two instructions of path 1.
  void write_attention(const std::string& agent, const std::string& split,
                       const std::string& first_word) const {
    std::string text = "{";
    for (const char* id : {"1_0", "1_1"}) {
      text += fmt::format("{}\"{}\": {{\"words\": [\"{}\", \"on\", \"stop\"], \"steps\": [",
                          text.size() > 1 ? ",\n" : "", id, first_word);
      for (int step = 0; step < 3; ++step) {
        text +=
            fmt::format(R"({}{{"action": "{}", "attention": [{}, {}, {}], "viewpoint": "v{}", )"
                        R"("heading": 1.5, "elevation": 0}})",
                        step > 0 ? ", " : "", step < 2 ? "forward" : "end", step == 0 ? 0.8 : 0.1,
                        step == 1 ? 0.8 : 0.1, step == 2 ? 0.8 : 0.1, step);
      }
      text += "]}";
    }
    write_file_atomically(
        run() / "models" / agent / "results" / fmt::format("{}.attention.json", split), text + "}");
  }

  /// A results file in which every episode walks `moves` viewpoints on from v0.
  void write_results(const std::filesystem::path& file, int moves) const {
    make_folder(file.parent_path());
    std::string text = "[";
    for (const char* id : {"1_0", "1_1", "1_2", "2_0", "2_1", "2_2"}) {
      if (text.size() > 1) text += ",\n";
      text += fmt::format("{{\"instr_id\": \"{}\", \"trajectory\": [", id);
      for (int i = 0; i <= moves; ++i) {
        text += fmt::format("{}[\"v{}\", 1.5, 0]", i > 0 ? ", " : "", i);
      }
      text += "]}";
    }
    write_file_atomically(file, text + "]\n");
  }

 private:
  static scan::Connectivity graph() {
    return graph::testing::connectivity(
        "row", {{0, 0, 1.5}, {2, 0, 1.5}, {4, 0, 1.5}, {6, 0, 1.5}, {8, 0, 1.5}},
        {{0, 1}, {1, 2}, {2, 3}, {3, 4}});
  }

  tests::TemporaryFolder folder_;
};

}  // namespace enfilade::report::testing
