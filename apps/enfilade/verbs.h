/// \file  The verbs of the command line `enfilade <verb>`.
#pragma once
#include <CLI/CLI.hpp>

namespace enfilade::apps {

// Each adds its verb with options, help and examples. `status` is the program's exit code if
// nothing is thrown. It is kSuccess before; a verb with another result sets another ExitCode.
void add_ask(CLI::App& app, int& status);            ///< evaluates a language model on a split
void add_contact_sheet(CLI::App& app, int& status);  ///< all viewpoints of a scan, or a trajectory
void add_continuous(CLI::App& app, int& status);     ///< navigation meshes, continuous episodes
void add_convert(CLI::App& app, int& status);        ///< the same content in another form
void add_dataset(CLI::App& app, int& status);        ///< paths and instructions for synthetic homes
void add_demo(CLI::App& app, int& status);           ///< R2R's baselines, then training
void add_doctor(CLI::App& app, int& status);         ///< which parts work on this computer
void add_evaluate(CLI::App& app, int& status);       ///< runs and scores a trained agent on splits
void add_export(CLI::App& app, int& status);         ///< files that other projects read
void add_features(CLI::App& app, int& status);       ///< an encoder's features of every view
void add_graph(CLI::App& app, int& status);          ///< graph check, draw, build, compare
void add_homes(CLI::App& app, int& status);          ///< makes synthetic homes, with pictures
void add_import(CLI::App& app, int& status);         ///< adds a user's panoramas to a scan
void add_mcp(CLI::App& app, int& status);            ///< tools over MCP for an assistant
void add_pack(CLI::App& app, int& status);           ///< packs a data set's pictures into stores
void add_panorama(CLI::App& app, int& status);       ///< a viewpoint's panorama as one picture
void add_pretrain(CLI::App& app, int& status);       ///< trains a small encoder on synthetic homes
void add_ray(CLI::App& app, int& status);            ///< a data job as tasks of Ray
void add_render(CLI::App& app, int& status);         ///< views of an agent
void add_report(CLI::App& app, int& status);         ///< an HTML page about a run
void add_run(CLI::App& app, int& status);            ///< runs an agent that does not learn
void add_r4r(CLI::App& app, int& status);            ///< longer paths, joined from R2R's
void add_sample(CLI::App& app, int& status);         ///< new paths from graphs and regions
void add_scan_mesh(CLI::App& app, int& status);      ///< makes a scan from a mesh
void add_score(CLI::App& app, int& status);          ///< scores a results file
void add_serve(CLI::App& app, int& status);          ///< serves pages and evaluation over HTTP
void add_slurm(CLI::App& app, int& status);          ///< a data job as an array of Slurm
void add_speak(CLI::App& app, int& status);          ///< instructions by a trained speaker
void add_stats(CLI::App& app, int& status);          ///< statistics of a data set
void add_study(CLI::App& app, int& status);          ///< success by number of homes
void add_submit(CLI::App& app, int& status);         ///< sends results to a server
void add_synth(CLI::App& app, int& status);          ///< synthetic homes without pictures
void add_table(CLI::App& app, int& status);          ///< a table of runs' scores, as in the paper
void add_filmstrip(CLI::App& app, int& status);      ///< views along a trajectory in a mesh
void add_top_down(CLI::App& app, int& status);       ///< a floor from above, with trajectories
void add_train(CLI::App& app, int& status);          ///< trains any agent

}  // namespace enfilade::apps
