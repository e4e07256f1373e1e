/// \file  The verbs of the command line `enfilade <verb>`.
#pragma once
#include <CLI/CLI.hpp>
#include <string>

namespace enfilade::apps {

/// Which Enfilade this is: "0.3.0, commit 0123456789ab"; only the version if the sources are not a
/// clone.
std::string version_with_commit();

using Add = void(CLI::App& app, int& status);
// Each adds its verb with options, help and examples. `status` is the program's exit code if
// nothing is thrown. It is kSuccess before; a verb with another result sets another ExitCode.
// clang-format off: a line each
namespace ask_verb {
Add add;
}  // namespace ask_verb
namespace contact_sheet_verb {
Add add;
}  // namespace contact_sheet_verb
namespace continuous_verb {
Add add;
}  // namespace continuous_verb
namespace convert_verb {
Add add;
}  // namespace convert_verb
namespace demo_verb {
Add add;
}  // namespace demo_verb
namespace doctor_verb {
Add add;
}  // namespace doctor_verb
namespace evaluate_verb {
Add add;
}  // namespace evaluate_verb
namespace export_verb {
Add add;
}  // namespace export_verb
namespace features_verb {
Add add;
}  // namespace features_verb
namespace filmstrip_verb {
Add add;
}  // namespace filmstrip_verb
namespace graph_verb {
Add add;
}  // namespace graph_verb
namespace graph_build_verb {
Add add;
}  // namespace graph_build_verb
namespace graph_compare_verb {
Add add;
}  // namespace graph_compare_verb
namespace homes_verb {
Add add;
}  // namespace homes_verb
namespace homes_verb {
Add add_dataset;
}  // namespace homes_verb
namespace homes_verb {
Add add_synth;
}  // namespace homes_verb
namespace import_verb {
Add add;
}  // namespace import_verb
namespace import_weights_verb {
Add add;
}  // namespace import_weights_verb
namespace mcp_verb {
Add add;
}  // namespace mcp_verb
namespace pack_verb {
Add add;
}  // namespace pack_verb
namespace panorama_verb {
Add add;
}  // namespace panorama_verb
namespace pretrain_verb {
Add add;
}  // namespace pretrain_verb
namespace r4r_verb {
Add add;
}  // namespace r4r_verb
namespace ray_verb {
Add add;
}  // namespace ray_verb
namespace render_verb {
Add add;
}  // namespace render_verb
namespace report_verb {
Add add;
}  // namespace report_verb
namespace run_verb {
Add add;
}  // namespace run_verb
namespace sample_verb {
Add add;
}  // namespace sample_verb
namespace scan_mesh_verb {
Add add;
}  // namespace scan_mesh_verb
namespace score_verb {
Add add;
}  // namespace score_verb
namespace serve_verb {
Add add;
}  // namespace serve_verb
namespace slurm_verb {
Add add;
}  // namespace slurm_verb
namespace speak_verb {
Add add;
}  // namespace speak_verb
namespace stats_verb {
Add add;
}  // namespace stats_verb
namespace study_verb {
Add add;
}  // namespace study_verb
namespace submit_verb {
Add add;
}  // namespace submit_verb
namespace table_verb {
Add add;
}  // namespace table_verb
namespace top_down_verb {
Add add;
}  // namespace top_down_verb
namespace train_verb {
Add add;
}  // namespace train_verb
// clang-format on

}  // namespace enfilade::apps
