// The command line of Enfilade.
#include "apps/common/program.h"
#include "apps/enfilade/verbs.h"

int main(int argc, char** argv) {
  using namespace enfilade::apps;
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
  add_contact_sheet(app, status);
  add_dataset(app, status);
  add_demo(app, status);
  add_doctor(app, status);
  add_evaluate(app, status);
  add_features(app, status);
  add_graph(app, status);
  add_homes(app, status);
  add_import(app, status);
  add_pack(app, status);
  add_panorama(app, status);
  add_pretrain(app, status);
  add_render(app, status);
  add_report(app, status);
  add_run(app, status);
  add_sample(app, status);
  add_scan_mesh(app, status);
  add_score(app, status);
  add_serve(app, status);
  add_stats(app, status);
  add_submit(app, status);
  add_synth(app, status);
  add_table(app, status);
  add_train(app, status);
  return run_program(app, argc, argv, status);
}
