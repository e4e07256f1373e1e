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

}  // namespace

int main(int argc, char** argv) {
  using namespace enfilade::apps;
  if (argc > 1 && std::string_view(argv[1]) == kTryGl) {
    return enfilade::render::try_gl(std::vector<std::string>(argv + 2, argv + argc));
  }
  enfilade::render::set_gl_trial({"/proc/self/exe", kTryGl});
  CLI::App app("Vision-and-language navigation: walk real buildings, run agents, score them.",
               "enfilade");
  app.set_version_flag("--version", EN_VERSION);
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);
  app.footer(
      "Each verb has its own help with examples: enfilade VERB --help.\n"
      "Exit codes: 0 done, 1 faults found in what was checked, 2 command line, 3 input or output\n"
      "files, 4 Enfilade's own failure.");
  int status = kSuccess;
  for (const auto add :
       {add_ask,       add_contact_sheet, add_continuous, add_convert,  add_dataset,
        add_demo,      add_doctor,        add_evaluate,   add_export,   add_features,
        add_filmstrip, add_graph,         add_homes,      add_import,   add_import_weights,
        add_mcp,       add_pack,          add_panorama,   add_pretrain, add_r4r,
        add_ray,       add_render,        add_report,     add_run,      add_sample,
        add_scan_mesh, add_score,         add_serve,      add_slurm,    add_speak,
        add_stats,     add_study,         add_submit,     add_synth,    add_table,
        add_top_down,  add_train}) {
    add(app, status);
  }
  return run_program(app, argc, argv, status);
}
