#include "tests/bad_input/harness.h"

namespace enfilade::bad_input {
namespace {

Case line(std::string input, std::string command, int exit_code, std::string says,
          std::function<void(Files&)> damage = {}) {
  return {"Command lines", std::move(input), std::move(command),
          exit_code,       std::move(says),  std::move(damage)};
}

}  // namespace

std::vector<Case> command_line_cases() {
  return {
      line("no verb", "", 2, "A subcommand is required"),
      line("an unknown verb", "fly", 2,
           "unknown verb \"fly\"; the verbs are ask, contact-sheet, continuous, convert, dataset, "
           "demo, doctor, evaluate, export, features, filmstrip, graph, homes, import, "
           "import-weights, mcp, pack, panorama, pretrain, r4r, ray, render, report, run, sample, "
           "scan-mesh, score, serve, slurm, speak, stats, study, submit, synth, table, top-down, "
           "train"),
      line("a job without a verb", "slurm -o {}/job", 2, "a verb is needed"),
      line("a job of a verb that cannot be cut", "slurm -o {}/job score x.json", 2,
           "\"score\": features and homes can be cut into shares"),
      line("a job that is cut already", "ray -o {}/job homes -o {}/h --shard 1/2", 2,
           "--shard: it is set for each share here"),
      line("a job of commands that are not there", "slurm -o {}/job --commands {}/none.txt", 3,
           "none.txt"),
      line("a job of commands behind a byte-order mark", "slurm -o {}/job --commands {}/c.txt", 0,
           "shares.sbatch: 1 shares",
           [](Files& f) { f.write("c.txt", "\xef\xbb\xbf# ours\r\nenfilade stats --data d\r\n"); }),
      line("a job of features without a file", "slurm -o {}/job features --weights random", 2,
           "features: -o FILE is needed"),
      line("an option that is none", "stats --data {} --colour", 2, "--colour"),
      line("an option without its value", "run --agent", 2, "--agent"),
      line("a number that is none", "run --data {} --batch many", 2,
           "--batch: \"many\" is not a whole number from 1 on"),
      line("a negative number", "run --data {} --batch -5", 2,
           "--batch: \"-5\" is not a whole number from 1 on"),
      line("no data set", "stats", 2, "no data set: give --data DIR or set ENFILADE_DATA"),
      line("a data set that is not there", "stats --data {}/none", 3, "{}/none: not a folder"),
      line("a data set that is a file", "stats --data {}/results.json", 3, "not a folder"),
      line("a data set with no annotations of the split", "run --data {} --split val_9", 3,
           "holds no annotations of split \"val_9\" of R2R; tried: r2r/R2R_val_9.json"),
      line("a task that is none", "score {}/results.json --data {} --split made --task r3r", 2,
           "no task \"r3r\"; there are r2r, r2r-last, r2r-back, r4r, rxr, reverie, cvdn, soon"),
      line("a scorer that is none",
           "score {}/results.json --data {} --split made --scorer official", 2,
           "no scorer \"official\" for R2R; there are enfilade, duet, hamt, valan, r4r_public"),
      line("a task of which there is no data",
           "score {}/results.json --data {} --split made --task soon", 3,
           "holds no annotations of split \"made\" of SOON; tried: soon/made.json, "
           "soon/made.json.gz"),
      line("a task that is none, of a run", "run --data {} --split made --task soup", 2,
           "no task \"soup\"; there are r2r,"),
      line("a table of a task that the data has not", "table {} --data {} --task soon", 2,
           "no results file AGENT_SPLIT.json"),
      line("a part of a split without the split", "score {}/results.json --data {} --part", 2,
           "score: which split? Give --split NAME, or --annotations FILE"),
      line("paths to join without a split", "r4r --data {} -o -", 2,
           "r4r: which split? Give --split NAME, or --annotations FILE"),
      line("a gap that is no length", "r4r --data {} --split made --gap -1 -o -", 2, "--gap"),
      line("an agent that is none", "run --data {} --split made --agent clever", 2,
           "agent \"clever\": there is none of that name; there are: random, reference, shortest"),
      line("a batch of none", "run --data {} --split made --batch 0", 2,
           "--batch: \"0\" is not a whole number from 1 on"),
      line("an oracle where goals are hidden", "run --data {} --split hidden --agent shortest", 2,
           "agent shortest needs the goal, which split hidden hides"),
      line("an output folder that is not there", "run --data {} --split made -o {}/no/r.json", 3,
           "{}/no/r.json: cannot write: No such file or directory"),
      line("an output that is a folder", "run --data {} --split made -o {}/r2r", 3,
           "{}/r2r: cannot write: Is a directory"),
      line("a full disk", "run --data {} --split made -o /dev/full", 3, "No space left on device"),
      line("a scan that is not listed", "graph draw three --data {} -o {}/a.svg", 2,
           "scan \"three\" is not one of the 2 scans"),
      line("a folder without graphs", "graph check {}/r2r", 3,
           "holds neither scans.txt nor any *_connectivity.json"),
      line("no seeds", "demo --data {} --seeds 0", 2, "--seeds"),
      line("a limit that is not a number", "graph check --data {} --longest-edge nan", 2,
           "\"nan\" is not a finite number from 0 on"),
      line("limits that contradict each other",
           "sample --data {} --min-edges 6 --max-edges 4 -o {}/new.json", 2, "edges"),
      line("a form of export that is none", "export --as duet -o {}/out --data {}", 2,
           "--as: duet not in"),
      line("features to export that are not named", "export --as duet-hdf5 -o {}/out --data {}", 2,
           "give --features FILE, the features of the views"),
      line("one form of boxes for many files",
           "export --as reverie-boxes --nested -o {}/out --data {}", 2, "--nested: for one file"),
      line("a labelled mesh that is not there",
           "export --as reverie-boxes --meshes {} -o {}/b.json --data {}", 2,
           "no labelled mesh of scan"),
      line("a scan to export that is not there",
           "export --as langnav --scans nowhere -o {}/out --data {}", 3,
           "nowhere_connectivity.json: cannot open"),
      line("results to convert without their form", "convert {}/results.json {}/out.json", 2,
           "results: give --to official or duet"),
      line("results to convert of an unknown benchmark",
           "convert {}/results.json {}/out.json --to duet", 2, "which benchmark? Give --task"),
      line("a file to convert that is not there", "convert {}/none.json {}/out.json", 3,
           "{}/none.json: cannot open"),
  };
}

}  // namespace enfilade::bad_input
