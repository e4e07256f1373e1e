/// \file  The verbs of the command line `enfilade <verb>`; each a file of this folder.
#pragma once
#include <CLI/CLI.hpp>

namespace enfilade::apps {

// Each adds its verb with options, help and examples; running it sets `status` to an ExitCode
// other than kSuccess if it has to.
void add_contact_sheet(CLI::App& app, int& status);  ///< all viewpoints of a scan, or a trajectory
void add_dataset(CLI::App& app, int& status);        ///< paths and instructions for model homes
void add_demo(CLI::App& app, int& status);           ///< the paper's table rows beside ours
void add_doctor(CLI::App& app, int& status);         ///< what this machine can do
void add_evaluate(CLI::App& app, int& status);       ///< a trained agent over splits
void add_features(CLI::App& app, int& status);       ///< what an encoder sees of every view
void add_graph(CLI::App& app, int& status);          ///< graph check, draw, build, compare
void add_homes(CLI::App& app, int& status);          ///< model homes
void add_import(CLI::App& app, int& status);         ///< one's own panoramas into a scan
void add_pack(CLI::App& app, int& status);           ///< a data set's pictures into stores
void add_panorama(CLI::App& app, int& status);       ///< all directions of a viewpoint at once
void add_pretrain(CLI::App& app, int& status);       ///< a small encoder for model homes
void add_render(CLI::App& app, int& status);         ///< what an agent sees
void add_report(CLI::App& app, int& status);         ///< everything about a run, as HTML
void add_run(CLI::App& app, int& status);            ///< an agent over a split
void add_sample(CLI::App& app, int& status);         ///< new paths from graphs and regions
void add_scan_mesh(CLI::App& app, int& status);      ///< a scan out of any mesh
void add_score(CLI::App& app, int& status);          ///< a results file
void add_serve(CLI::App& app, int& status);          ///< pages and evaluation over HTTP
void add_stats(CLI::App& app, int& status);          ///< what a data set is like
void add_submit(CLI::App& app, int& status);         ///< results to a server
void add_synth(CLI::App& app, int& status);          ///< model homes without pictures
void add_table(CLI::App& app, int& status);          ///< the paper's table of what was run
void add_train(CLI::App& app, int& status);          ///< the sequence-to-sequence agent

}  // namespace enfilade::apps
