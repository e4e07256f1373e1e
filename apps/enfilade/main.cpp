// The command line of Enfilade.
#include <string>
#include <string_view>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/render/devices.h"

namespace {

// A verb that no user gives: this program starts itself with it, to try drivers of OpenGL.
constexpr const char* kTryGl = "try-gl";

struct VerbGroup {
  const char* name;
  std::vector<void (*)(CLI::App&, int&)> adders;
};

// As `enfilade --help` lists the verbs.
const std::vector<VerbGroup>& verb_groups() {
  using namespace enfilade::apps;
  static const std::vector<VerbGroup> kAll{
      {"Look",
       {render_verb::add, panorama_verb::add, contact_sheet_verb::add, filmstrip_verb::add,
        top_down_verb::add}},
      {"Data",
       {homes_verb::add, homes_verb::add_synth, homes_verb::add_dataset, import_verb::add,
        scan_mesh_verb::add, graph_verb::add, continuous_verb::add, pack_verb::add,
        convert_verb::add, export_verb::add, sample_verb::add, r4r_verb::add, stats_verb::add}},
      {"Run and score",
       {demo_verb::add, run_verb::add, evaluate_verb::add, score_verb::add, table_verb::add,
        report_verb::add}},
      {"Train",
       {features_verb::add, pretrain_verb::add, train_verb::add, study_verb::add, speak_verb::add,
        import_weights_verb::add}},
      {"People", {serve_verb::add, submit_verb::add}},
      {"Models", {ask_verb::add, mcp_verb::add}},
      {"Machines", {doctor_verb::add, slurm_verb::add, ray_verb::add}},
  };
  return kAll;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace enfilade::apps;
  if (argc > 1 && std::string_view(argv[1]) == kTryGl) {
    return enfilade::render::try_gl(std::vector<std::string>(argv + 2, argv + argc));
  }
  enfilade::render::set_gl_trial({"/proc/self/exe", kTryGl});
  CLI::App app("Vision-and-language navigation: render real buildings, run agents, score them.",
               "enfilade");
  app.set_version_flag("--version", EN_VERSION);
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);
  app.footer(
      "Each verb has its own help with examples: enfilade VERB --help.\n"
      "Exit codes: 0 done, 1 faults found in what was checked, 2 command line, 3 input or output\n"
      "files, 4 Enfilade's own failure.");
  int status = kSuccess;
  for (const auto& [group, adders] : verb_groups()) {
    for (const auto add : adders) {
      add(app, status);
      app.get_subcommands({}).back()->group(group);
    }
  }
  return run_program(app, argc, argv, status);
}
