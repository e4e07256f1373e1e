// The command line of Enfilade.
#include <string>
#include <string_view>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/learning/import_weights.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/render/gl_devices.h"

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
  static const std::vector<VerbGroup> all{
      {"Look", {add_render, add_panorama, add_contact_sheet, add_filmstrip, add_top_down}},
      {"Data",
       {add_homes, add_synth, add_dataset, add_import, add_scan_mesh, add_graph, add_continuous,
        add_pack, add_convert, add_export, add_sample, add_r4r, add_stats}},
      {"Run and score", {add_demo, add_run, add_evaluate, add_score, add_table, add_report}},
      {"Train", {add_features, add_pretrain, add_train, add_study, add_speak, add_import_weights}},
      {"People", {add_serve, add_submit}},
      {"Models", {add_ask, add_mcp}},
      {"Machines", {add_doctor, add_slurm, add_ray}},
  };
  return all;
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
