#include <string>

#include "tests/bad_input/harness.h"

namespace enfilade::bad_input {
namespace {

using Damage = std::function<void(Files&)>;

Case homes(std::string input, const std::string& arguments, int exit_code, std::string says,
           Damage damage = {}) {
  return {"Model homes", std::move(input), "homes " + arguments,
          exit_code,     std::move(says),  std::move(damage)};
}

std::vector<Case> options() {
  const std::string out = "-o {}/homes ";
  return {
      homes("no folder to write to", "", 2, "--output is required"),
      homes("a preset that is none", out + "--preset huge", 2,
            "--preset: huge not in {small,pretty,demo,full,graphs,training}"),
      homes("no homes", out + "--homes 0", 2,
            "--homes: \"0\" is not a whole number from 1 to 10000"),
      homes("a seed below 0", out + "--seed -1", 2, "--seed: \"-1\" is not a whole number from 0"),
      homes("a seed that is no whole number", out + "--seed 1.5", 2, "--seed: \"1.5\" is not"),
      homes("a seed of more than 64 bits", out + "--seed 99999999999999999999", 2, "--seed: "),
      homes("homes smaller than any", out + "--area 5", 2,
            "--area: \"5\" is not a finite number from 60 to 3000"),
      homes("homes larger than any", out + "--area 5000", 2, "from 60 to 3000"),
      homes("an area that is no number", out + "--area nan", 2, "--area: \"nan\" is not"),
      homes("a kind that is none", out + "--kind castle", 2,
            "--kind: castle not in {house,flat,office,hotel}"),
      homes("faces larger than any", out + "--size 5000", 2,
            "--size: \"5000\" is not a whole number from 0 to 4096"),
      homes("three rays a texel", out + "--samples 3", 2, "samples: 3, not 1, 4, 9 or 16"),
      homes("paths below 0", out + "--paths -1", 2, "--paths: \"-1\" is not"),
      homes(
          "a part that is none", out + "--parts walls", 2,
          "--parts: walls not in {skybox,strips,depth,labels,undistorted,house,mesh,all,habitat}"),
      homes("more threads than any", out + "--threads 9999999999", 2,
            "--threads: \"9999999999\" is not a whole number from 0 to 1024"),
      homes("a share that is none", out + "--shard 0/4", 2,
            "--shard \"0/4\": K/N is expected, the K-th of N shares, K from 1 to N"),
      homes("a share past the last", out + "--shard 5/4", 2, "--shard \"5/4\": K/N is expected"),
      homes("a share in words", out + "--shard half", 2, "--shard \"half\": K/N is expected"),
      homes("an output that is a file", "-o {}/results.json", 3,
            "{}/results.json: cannot make the folder: Not a directory"),
      homes("an output below a file", "-o {}/results.json/homes", 3,
            "{}/results.json/homes: cannot make the folder: Not a directory"),
      homes("a folder that holds something else", "-o {}", 3,
            "{}: holds files that are not model homes; name a new or an empty folder"),
      {"Model homes",
       "fewer homes without pictures than splits by building take",
       "synth " + out + "--buildings 2",
       2,
       "--buildings: \"2\" is not a whole number from 3 to 10000",
       {}},
      {"Model homes",
       "homes without pictures, in a folder that holds something else",
       "synth -o {}",
       3,
       "{}: holds files that are not model homes; name a new or an empty folder",
       {}},
  };
}

// Two homes that are done, by their list.
constexpr const char* kList = R"({"format": "enfilade-homes", "version": 1, "synthetic": true,
 "options": {"homes": 2, "seed": 1, "kind": "flat", "least_area": 60, "most_area": 60,
  "face_size": 0, "samples": 1, "jpeg_quality": 92},
 "homes": [
  {"scan": "home0001", "kind": "flat", "seed": 5, "storeys": null, "area": 60, "viewpoints": 9,
   "edges": 9, "triangles": 9, "lines": [{"walls": [0, 0, 4, 0]}], "rooms": [
    {"type": "b", "name": "bedroom", "storey": 0, "floor": [0, 0, 4, 3], "elevation": 0,
     "viewpoints": []}]},
  {"scan": "home0002", "kind": "flat", "seed": 6, "storeys": null, "area": 60, "viewpoints": 9,
   "edges": 9, "triangles": 9, "lines": [{}], "rooms": []}]}
)";
constexpr const char* kListFile = "homes/homes.json";

Case listed(std::string input, int exit_code, std::string says, Damage damage,
            const std::string& more = "") {
  return {"Lists of homes",
          std::move(input),
          "homes -o {}/homes --preset small --size 0 --paths 0" + more,
          exit_code,
          std::move(says),
          [damage = std::move(damage)](Files& files) {
            files.write(kListFile, kList);
            damage(files);
          }};
}

Damage edited(const std::string& from, const std::string& to) {
  return [=](Files& files) { files.edit(kListFile, from, to); };
}

std::vector<Case> lists() {
  return {
      listed("a list of two homes that are done: nothing is made", 0, "2 homes", [](Files&) {}),
      listed("an empty list file", 3, "{}/homes/homes.json: $: line 1, column 1: the file is empty",
             [](Files& f) { f.write(kListFile, ""); }),
      listed("a list cut off in the middle", 3, "the file ends too early",
             [](Files& f) { f.write(kListFile, std::string(kList).substr(0, 300)); }),
      listed("a list that is an array", 3, "{}/homes/homes.json: $: array of 0, not an object",
             [](Files& f) { f.write(kListFile, "[]"); }),
      listed("a list of another format", 3, "only \"enfilade-homes\", version 1, can be read",
             edited("enfilade-homes", "my-homes")),
      listed("a list of another version", 3, "version 2; only \"enfilade-homes\", version 1",
             edited("\"version\": 1", "\"version\": 2")),
      listed("a list without options", 3, "$: has no field \"options\" [missing-field]",
             edited("\"options\"", "\"notions\"")),
      listed("homes of another seed", 3, "(seed: 2 there, 1 asked for); name another folder",
             edited("\"seed\": 1", "\"seed\": 2")),
      listed(
          "fewer homes than are asked for", 3, "(homes: 2 there, 3 asked for)", [](Files&) {},
          " --homes 3"),
      listed("a set's seed below 0", 3, "$.options.seed: -1, below 0 [bad-number]",
             edited("\"seed\": 1", "\"seed\": -1")),
      listed("a storey past 32 bits", 3,
             "$.homes[0].rooms[0].storey: 4294967296, too large [bad-number]",
             edited("\"storey\": 0", "\"storey\": 4294967296")),
      listed("a set's kind that is none", 3, "$.options.kind: \"castle\" is no kind [bad-kind]",
             edited("\"kind\": \"flat\"", "\"kind\": \"castle\"")),
      listed("a home that is not of the set", 3,
             "$.homes[1].scan: \"home0009\" is none of the 2 homes of this set: home0001 to "
             "home0002 [unknown-scan]",
             edited("home0002", "home0009")),
      listed("a home without a seed", 3, "$.homes[0]: has no field \"seed\"",
             edited("\"seed\": 5, ", "")),
      listed("a home too small for a plan", 3,
             "$.homes[0]: area: 6 m2, not from 60 to 3000, or 0 [bad-plan]",
             edited("\"area\": 60, \"viewpoints\"", "\"area\": 6, \"viewpoints\"")),
      listed("a flat on two storeys", 3,
             "$.homes[0]: storeys: 2, but flats and hotel floors have 1 [bad-plan]",
             edited("\"storeys\": null", "\"storeys\": 2")),
      listed("a room's type that is a word", 3,
             "$.homes[0].rooms[0]: type \"bedroom\", not one letter [bad-type]",
             edited("\"type\": \"b\"", "\"type\": \"bedroom\"")),
      listed("a room's floor with three corners", 3,
             "$.homes[0].rooms[0].floor: 3 numbers, not 4 [bad-rectangle]",
             edited("[0, 0, 4, 3]", "[0, 0, 4]")),
      listed("a room without a floor", 3,
             "$.homes[0].rooms[0]: its floor is missing or empty [bad-rectangle]",
             edited("\"floor\": [0, 0, 4, 3], ", "")),
      listed("a storey named twice", 3,
             "$.homes[0].rooms[0].storey: given twice in one object [repeated-field]",
             edited("\"storey\": 0", "\"storey\": 0, \"storey\": 1")),
      listed("a line of a plan that ends nowhere", 3,
             "$.homes[0].lines[0].walls: 3 numbers, not 4 for each line [bad-lines]",
             edited("[0, 0, 4, 0]", "[0, 0, 4]")),
      listed("a line's end past any home", 3,
             "$.homes[0].lines[0].walls[2]: 1e+300, not from -1000000 to 1000000 [bad-number]",
             edited("[0, 0, 4, 0]", "[0, 0, 1e300, 0]")),
      listed("a list without lines, of an earlier version, and no graph", 3,
             "{}/homes/connectivity/home0001_connectivity.json: cannot open",
             edited("\"lines\": [{\"walls\": [0, 0, 4, 0]}], ", "")),
      listed("a share's list that is broken", 3, "{}/homes/shards/home0002.json: $",
             [](Files& f) { f.write("homes/shards/home0002.json", "{"); }),
  };
}

Case corrected(std::string input, int exit_code, std::string says, const std::string& file,
               const std::string& content) {
  return {"Corrections of homes",
          std::move(input),
          "homes -o {}/new --preset small --homes 1 --size 0 --paths 0 --corrections {}/fixed",
          exit_code,
          std::move(says),
          [=](Files& f) {
            if (!file.empty()) f.write("fixed/" + file, content);
          }};
}

std::vector<Case> corrections() {
  constexpr const char* kFile = "home0001_corrections.json";
  return {
      corrected("corrections that change nothing", 0, "1 homes", kFile,
                R"({"scan": "home0001", "corrections": []})"),
      corrected("a folder that is not there", 3, "{}/fixed: cannot open: No such file", "", ""),
      corrected("a folder without corrections", 3,
                "{}/fixed: holds no corrections: SCAN_corrections.json is expected", "notes.txt",
                "door 3 is locked"),
      corrected("corrections of a home that is not in the set", 3,
                "{}/fixed/home0007_corrections.json: \"home0007\" is none of the 1 homes of this "
                "set: home0001 to home0001 [unknown-scan]",
                "home0007_corrections.json", R"({"scan": "home0007", "corrections": []})"),
      corrected("corrections of another home than their name says", 3,
                "$.scan: \"home0002\", and the file is named after \"home0001\" [other-scan]",
                kFile, R"({"scan": "home0002", "corrections": []})"),
      corrected("corrections cut off in the middle", 3, "the file ends too early", kFile,
                R"({"scan": "home0001", "corrections": [)"),
      corrected("a correction nobody signed", 3, "$.corrections[0].who: is empty", kFile,
                R"({"scan": "home0001", "corrections": [
 {"action": "exclude", "from": "a", "who": "", "why": "dark"}]})"),
      corrected("a correction of a viewpoint that is not there", 3,
                "{}/fixed/home0001_corrections.json: $.corrections[0].to: \"b\" is no viewpoint "
                "of home0001 [unknown-viewpoint]",
                kFile, R"({"scan": "home0001", "corrections": [
 {"action": "add-edge", "from": "a", "to": "b", "who": "Ada", "why": "a curtain"}]})"),
  };
}

// The data set of all cases, with a list that makes its scan "one" a home.
Case spoken(std::string input, const std::string& arguments, int exit_code, std::string says,
            Damage damage = {}) {
  return {"Paths in homes",
          std::move(input),
          "dataset " + arguments,
          exit_code,
          std::move(says),
          [damage = std::move(damage)](Files& files) {
            files.write("homes.json", kList)
                .edit("homes.json", "home0001", "one")
                .edit("homes.json", "home0002", "two")
                .edit("homes.json", "\"rooms\": []}",
                      "\"rooms\": []}, {\"scan\": \"three\", \"kind\": null, \"seed\": 1, "
                      "\"storeys\": null, \"area\": 0, \"viewpoints\": 0, \"edges\": 0, "
                      "\"triangles\": 0, \"rooms\": []}");
            if (damage) damage(files);
          }};
}

std::vector<Case> paths() {
  return {
      spoken("no folder", "", 2, "folder is required"),
      spoken("a folder that is not there", "{}/none", 3, "{}/none/homes.json: cannot open"),
      spoken("a folder that is a file", "{}/results.json", 3,
             "{}/results.json/homes.json: cannot open: Not a directory"),
      spoken("a folder without homes", "{}/r2r", 3, "{}/r2r/homes.json: cannot open"),
      spoken("no paths", "{} --paths 0", 2, "--paths: \"0\" is not a whole number from 1"),
      spoken("a seed below 0", "{} --seed -1", 2, "--seed: \"-1\" is not"),
      spoken("all paths for val seen", "{} --val-seen 1", 2,
             "--val-seen: \"1\" is not a finite number from 0 to 0.99"),
      spoken("a share that is no number", "{} --val-seen nan", 2, "--val-seen: \"nan\" is not"),
      spoken("a broken list", "{}", 3, "{}/homes.json: $",
             [](Files& f) { f.write("homes.json", "{"); }),
      spoken("two homes", "{}", 3, "{}: 2 homes, but splits by building need 3 at least",
             [](Files& f) { f.write("homes.json", kList); }),
      spoken("no graphs", "{}", 3, "{}/connectivity/scans.txt: cannot open",
             [](Files& f) { f.remove(kScans); }),
      spoken("a broken graph", "{}", 3, "one_connectivity.json: $",
             [](Files& f) { f.write(kGraph, "[7]"); }),
      spoken("no rooms", "{}", 3, "{}/regions/region_to_panorama.json: cannot open",
             [](Files& f) { f.remove(kRegions); }),
      spoken("broken rooms", "{}", 3, "{}/regions/region_to_panorama.json: $",
             [](Files& f) { f.write(kRegions, "[]"); }),
  };
}

}  // namespace

std::vector<Case> home_cases() {
  std::vector<Case> all;
  for (const auto& part : {options(), lists(), corrections(), paths()}) {
    all.insert(all.end(), part.begin(), part.end());
  }
  return all;
}

}  // namespace enfilade::bad_input
