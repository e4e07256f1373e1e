// enfilade mcp: an assistant walks episodes, over standard input and output.
#include "enfilade/arena/mcp.h"

#include <fmt/format.h>
#include <algorithm>
#include <iostream>
#include <memory>
#include <string>

#include "apps/common/program.h"
#include "apps/enfilade/arena_world.h"
#include "apps/enfilade/task_option.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/arena/world.h"

namespace enfilade::apps::mcp_verb {
namespace {

struct Options {
  std::string data, task, split = "val_unseen", subset, output = "played", words = "none";
  bool pictures = false;
  std::uint32_t steps = 0;
  int port = -1;  // below 0: standard input and output
  arena::McpConfig config;
};

void play(Options& options) {
  const auto data = std::make_shared<const dataset::Dataset>(open_data(options.data));
  OpenedWorld opened = open_world(data, options.task, options.split,
                                  options.words == "labels" ? arena::label_words : WordsMaker());
  options.config.episodes = arena::subset_named(*opened.world, options.subset);
  options.config.limits = limits_of(*opened.world, options.steps);
  options.config.folder = options.output;
  options.config.version = version_with_commit();
  if (options.pictures) options.config.pictures = arena::PictureKind::kStrip;
  arena::McpServer server(std::move(opened.world), opened.sights, options.config);
  const std::string done =
      fmt::format("{} of {} are done", server.done(), counted(server.size(), "episode"));
  if (options.port >= 0) {
    serve_mcp_over_http(server, options.port, done);
  } else {
    say(stderr, "{}; an assistant is waited for on standard input\n", done);
  }
  for (std::string line; options.port < 0 && server.read_message(std::cin, line);) {
    if (line.empty()) continue;
    for (const std::string& answer : server.handle(line)) std::cout << answer << '\n';
    std::cout.flush();
  }
  say(stderr, "{} of {} are done: {}/results.json\n", server.done(),
      counted(server.size(), "episode"), options.output);
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb =
      *app.add_subcommand("mcp", "Serve episodes by the Model Context Protocol, on standard input");
  const auto options = std::make_shared<Options>();
  add_data_option(verb, options->data);
  add_task_option(verb, options->task, "r2r, or what the data set has", Worlds::kBoth);
  add_setting(verb, "--split", options->split, "NAME", "train, val_seen, val_unseen, ...");
  add_subset_option(verb, options->subset);
  verb.add_flag("--pictures", options->pictures,
                "Send panoramas; on a graph, with the viewpoints' names drawn");
  add_whole_number(verb, "--picture-size", options->config.picture_size,
                   "Size of images, pixels, 64 to 2048");
  add_setting(verb, "--words", options->words, "SOURCE",
              "Text about views: none, or labels (from semantic layers)",
              CLI::IsMember({"none", "labels"}));
  add_steps_option(verb, options->steps);
  verb.add_option("--port", options->port,
                  "Listen at http://127.0.0.1:PORT/mcp instead; 0: any free port")
      ->check(CLI::Range(0, 65535));
  add_setting(verb, "-o,--output", options->output, "DIR",
              "Transcripts and results; episodes with a transcript are skipped");
  set_examples(verb, {"enfilade mcp --data homes --subset 10 -o played",
                      "enfilade mcp --data homes --port 8001 -o played",
                      "enfilade mcp --pictures --task reverie --split val_unseen"});
  verb.callback([options] { play(*options); });
}

}  // namespace enfilade::apps::mcp_verb
