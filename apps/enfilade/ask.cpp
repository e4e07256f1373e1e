// enfilade ask: a language model walks a split.
#include "enfilade/arena/ask.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/arena_world.h"
#include "apps/enfilade/task_option.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/arena/stand_in.h"
#include "enfilade/arena/world.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/names.h"
#include "enfilade/core/numbers.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::apps::ask_verb {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string data, task, split = "val_unseen", subset;
  std::string endpoint, key_file, stand_in, prompt = "text", answers;
  std::string cache, prices, output = "asked";
  std::string words = "none", captioner, captioner_model;
  bool replay = false, list = false;
  std::uint32_t steps = 0;
  double timeout = 120;
  std::string temperature = "0", seed = "1", limit_field, window = "auto";
  std::string key_header, headers;
  std::int64_t answer_tokens = 0, most_tokens = 0;
  arena::AskConfig ask;
};

/// What was not the model's choice: a walk of a model that never answered is no bad walk.
void print_unanswered(const arena::AskReport& report) {
  constexpr std::array<std::string_view, 5> kReasons{
      "without a reason", "empty", "cut off at the limit of tokens (--answer-tokens)",
      "refused by the model", "taken away by a filter"};
  std::vector<std::string> parts;
  std::size_t all = 0;
  for (const auto& [flaw, count] : report.unanswered) {
    all += count;
    parts.push_back(fmt::format("{} {}", count, kReasons.at(static_cast<std::size_t>(flaw))));
  }
  if (all > 0) {
    say("{} of the answers had no call: {}\n", all, fmt::join(parts, ", "));
  }
  if (report.shortened > 0) {
    say("{}: older steps were left out (--window, and what the model's context holds)\n",
        counted(report.shortened, "episode"));
  }
  if (!report.adjusted.empty()) {
    say("requests differ from the usual ones: {}\n", fmt::join(report.adjusted, ", "));
  }
}

/// Of the model; no value: it is not asked for.
std::optional<arena::Price> price_of(const Options& options) {
  if (options.prices.empty()) return std::nullopt;
  const auto prices = arena::load_prices(options.prices);
  const auto price = prices.find(options.ask.chat.model);
  if (price == prices.end()) {
    throw UsageError(
        fmt::format("--prices: {} has no {}", options.prices, quote(options.ask.chat.model)));
  }
  return price->second;
}

void print_report(const arena::AskReport& report, const std::optional<arena::Price>& price) {
  say("{} of {} episodes are done", report.done, report.episodes);
  for (const auto& [ending, count] : report.endings) {
    say(", {} {}", count, name_of(ending));
  }
  say("; {} {} could not be carried out\n", report.mistakes,
      report.mistakes == 1 ? "call" : "calls");
  print_unanswered(report);
  const arena::Ledger& ledger = report.ledger;
  say("{} answers ({} requests), {} pictures, {} tokens in, {} out, {:.0f} s of answers",
      ledger.answers, ledger.attempts, ledger.pictures, ledger.prompt_tokens, ledger.answer_tokens,
      ledger.seconds);
  if (price) say(", {:.2f} for them", money_of(ledger, *price));
  say("\n");
}

/// "none" or what another check accepts.
CLI::Validator none_or(const CLI::Validator& check) {
  return CLI::Validator(
      [check](std::string& text) { return text == "none" ? std::string() : check(text); },
      check.get_description());
}

/// The settings of requests that "none" leaves out.
void read_request_options(Options& options) {
  arena::ChatConfig& chat = options.ask.chat;
  chat.temperature =
      options.temperature == "none" ? std::nullopt : parse_number<double>(options.temperature);
  chat.seed = options.seed == "none" ? std::nullopt : parse_number<std::int64_t>(options.seed);
  if (options.answer_tokens > 0) chat.most_tokens = options.answer_tokens;
  if (options.most_tokens > 0) options.ask.most_tokens = options.most_tokens;
  if (!options.limit_field.empty()) {
    options.ask.limit_field = find_enum<arena::LimitField>(options.limit_field);
  }
  options.ask.say = [](const std::string& sentence) { say(stderr, "{}\n", sentence); };
  options.ask.shorten = options.window == "auto";
  chat.window = parse_number<std::uint32_t>(options.window);
}

/// And says in the run's settings where words come from.
WordsMaker words_maker(Options& options, arena::Endpoint* captioner, arena::AnswerCache& cache) {
  options.ask.words = options.words;
  if (options.words == "labels") return arena::label_words;
  if (options.words == "none") return {};
  arena::CaptionConfig config{.chat = options.ask.chat,
                              .picture_size = options.ask.picture_size,
                              .attempts = options.ask.attempts,
                              .longest_wait = options.ask.longest_wait,
                              .say = options.ask.say};
  if (!options.captioner_model.empty()) config.chat.model = options.captioner_model;
  if (options.captioner.empty()) {
    config.limit = options.ask.limit_field.value_or(config.limit);
  } else {
    config.chat.extra.clear();  // for another server
  }
  options.ask.words = "captions by " + config.chat.model;
  return [config, captioner, &cache](const arena::ViewSources& sights) {
    return arena::caption_words(sights, config, captioner, cache);
  };
}

ExitCode ask(Options& options) {
  const int sources = (options.endpoint.empty() ? 0 : 1) + (options.stand_in.empty() ? 0 : 1) +
                      (options.replay ? 1 : 0);
  if (sources != 1 && !options.list) {
    throw UsageError(
        "ask: one of --endpoint URL (a server of OpenAI's form), --stand-in RULE (no model: a rule "
        "answers) and --replay (answers in the cache alone) is needed");
  }
  if (!options.stand_in.empty() && options.ask.chat.model.empty()) {
    options.ask.chat.model = "stand-in-" + options.stand_in;
  }
  if (options.ask.chat.model.empty() && !options.list) {
    throw UsageError("ask: --model NAME is needed, as the server calls it");
  }
  const bool captioner_named = !options.captioner.empty() || !options.captioner_model.empty();
  if (captioner_named && options.words != "captions") {
    throw UsageError("--captioner, --captioner-model: need --words captions");
  }
  const auto data = std::make_shared<const dataset::Dataset>(open_data(options.data));
  if (options.list) {
    const OpenedWorld opened = open_world(data, options.task, options.split);
    for (const std::size_t e : arena::subset_named(*opened.world, options.subset)) {
      say("{}\n", opened.world->episodes().id(e));
    }
    return kSuccess;
  }
  // What is read from files is read before the first request, which may cost money.
  const std::optional<arena::Price> price = price_of(options);
  const arena::Prompt prompt = arena::Prompt::open(options.prompt);
  if (!options.answers.empty()) {
    options.ask.answers = find_enum<arena::Answers>(options.answers);
    if (!options.ask.answers) {
      throw UsageError(fmt::format("--answers {}: one of {} is expected", options.answers,
                                   fmt::join(names_of(arena::Answers()), ", ")));
    }
  }
  read_request_options(options);

  std::unique_ptr<arena::StandIn> stand_in;
  std::unique_ptr<arena::Endpoint> endpoint;
  if (!options.stand_in.empty()) {
    arena::StandInConfig config{.rule = arena::rule_named(options.stand_in)};
    config.seed = static_cast<std::uint64_t>(options.ask.chat.seed.value_or(1));
    stand_in = std::make_unique<arena::StandIn>(open_world(data, options.task, options.split).world,
                                                config);
    endpoint = arena::make_http_endpoint({.url = stand_in->url()});
  } else if (!options.replay) {
    endpoint = arena::make_http_endpoint(
        {.url = options.endpoint,
         .key = read_secret(options.key_file, {"ENFILADE_MODEL_KEY", "OPENAI_API_KEY"}),
         .key_header = options.key_header,
         .headers = options.headers.empty() ? decltype(arena::HttpEndpointConfig::headers)()
                                            : arena::load_headers(options.headers),
         .timeout = options.timeout});
  }
  const fs::path folder = options.output;
  arena::AnswerCache cache(options.cache.empty() ? OutputFolder(folder).folder("cache")
                                                 : OutputFolder(options.cache));
  std::unique_ptr<arena::Endpoint> captioner;
  if (!options.captioner.empty() && !options.replay) {
    captioner = arena::make_http_endpoint({.url = options.captioner,
                                           .key = read_secret("", {"ENFILADE_CAPTIONER_KEY"}),
                                           .timeout = options.timeout});
  }
  const OpenedWorld opened =
      open_world(data, options.task, options.split,
                 words_maker(options, captioner ? captioner.get() : endpoint.get(), cache));
  const arena::World& world = *opened.world;
  const std::vector<std::size_t> which = arena::subset_named(world, options.subset);
  options.ask.limits = limits_of(world, options.steps);
  const arena::AskReport report =
      arena::ask(world, opened.sights, which, prompt, options.ask, endpoint.get(), cache, folder,
                 progress_bar(options.ask.chat.model + ", " + options.split));
  say("{} with the prompt {}, answers as {}, on {} {}{}\n", options.ask.chat.model, prompt.name(),
      enum_name(report.answers), opened.title, options.split,
      data->synthetic() ? ", SYNTHETIC" : "");
  print_report(report, price);
  if (report.done > 0) {
    OutputFolder(folder).write("usage.json", arena::usage_json(report.ledger, price));
  }
  for (const std::string& one : report.refused) say(stderr, "{}\n", one);
  for (const std::string& one : report.given_up) {
    say(stderr, "{} (left for the next run)\n", one);
  }
  if (report.done > 0 && !world.episodes().goals_hidden()) {
    tasks::Trajectories results =
        tasks::load_trajectories(folder / "results.json", world.episodes(), tasks::Coverage::kPart);
    const tasks::Split part = part_of(world.episodes(), results);
    print_score(results, part, agents::open_buildings(part.benchmark(), data->folder()).get());
    say("With {} episodes a share of one half may be {:.1f} points off by chance.\n", report.done,
        100 * arena::chance_of(report.done));
  }
  say("{}: results.json, transcripts/, run.json, usage.json\n", options.output);
  return report.done == report.episodes ? kSuccess : kFaultsFound;
}

}  // namespace

void add(CLI::App& app, int& status) {
  CLI::App& verb = *app.add_subcommand("ask", "Evaluate a language model on a split");
  const auto options = std::make_shared<Options>();
  add_data_option(verb, options->data);
  add_value(verb, "--endpoint", options->endpoint, "URL",
            "OpenAI-compatible server: http://127.0.0.1:8000/v1");
  add_value(verb, "--key-header", options->key_header, "NAME",
            "Header of the key, such as api-key (default: Authorization: Bearer)");
  add_value(verb, "--headers", options->headers, "FILE",
            "File with further headers of requests, a line \"Name: value\" each");
  add_value(verb, "--model", options->ask.chat.model, "NAME", "Name of the model at the server");
  add_value(verb, "--key-file", options->key_file, "FILE",
            "File with the server's key, which is never stored (default: the environment "
            "variable ENFILADE_MODEL_KEY, or OPENAI_API_KEY)");
  add_value(
      verb, "--stand-in", options->stand_in, "RULE",
      fmt::format("A rule in place of a model: {}", fmt::join(names_of(arena::Rule()), ", ")));
  verb.add_flag("--replay", options->replay, "Use cached responses only; send no request");
  add_task_option(verb, options->task, "r2r, or what the data set has", Worlds::kBoth);
  add_setting(verb, "--split", options->split, "NAME", "train, val_seen, val_unseen, ...");
  add_subset_option(verb, options->subset);
  verb.add_flag("--list", options->list, "Print the subset's instruction ids; send no request");
  add_setting(verb, "--prompt", options->prompt, "NAME|FILE",
              fmt::format("One of {}, or a template file (docs/arena.md)",
                          fmt::join(arena::Prompt::names(), ", ")));
  add_value(verb, "--answers", options->answers, "FORM",
            "Form of the model's actions: tools, json or text (default: the prompt's, or what "
            "the server takes)");
  add_setting(verb, "--words", options->words, "SOURCE",
              "Text about views: none, labels (from semantic layers) or captions (a model's)",
              CLI::IsMember({"none", "labels", "captions"}));
  add_value(verb, "--captioner", options->captioner, "URL",
            "Server for captions; its key: environment variable ENFILADE_CAPTIONER_KEY (default: "
            "the endpoint)");
  add_value(verb, "--captioner-model", options->captioner_model, "NAME",
            "Model for captions (default: the model)");
  add_steps_option(verb, options->steps);
  add_whole_number(verb, "--parallel", options->ask.parallel,
                   "Episodes at once; results stay the same");
  add_setting(verb, "--temperature", options->temperature, "T",
              "Sampling temperature, 0 to 2; none: not sent", none_or(finite_number(0, 2)));
  add_setting(verb, "--seed", options->seed, "N", "Seed of each request; none: not sent",
              none_or(whole_number(0, std::numeric_limits<std::int64_t>::max())));
  add_value(verb, "--limit-field", options->limit_field, "NAME",
            "max_tokens or max_completion_tokens (default: what the server takes)")
      ->check(CLI::IsMember({"max_tokens", "max_completion_tokens"}));
  add_value(verb, "--extra", options->ask.chat.extra, "JSON",
            R"(Further fields of requests: {"reasoning_effort": "low"}; null removes one)");
  add_setting(verb, "--window", options->window, "N",
              "Steps that are sent again: a number, all, or auto (what fits)",
              CLI::IsMember({"auto", "all"}) | whole_number(0, 1'000'000));
  add_whole_number(verb, "--answer-tokens", options->answer_tokens,
                   "Most tokens per response; 0: the server's limit", 0);
  add_whole_number(verb, "--most-tokens", options->most_tokens,
                   "Stop after this number of tokens, in and out; 0: no limit", 0);
  add_setting(verb, "--timeout", options->timeout, "S",
              "Seconds for a whole response, from its connection on", finite_number(0.001, 3600));
  add_whole_number(verb, "--attempts", options->ask.attempts,
                   "Requests for a response before its episode is left");
  add_setting(verb, "--longest-wait", options->ask.longest_wait, "S",
              "Most seconds between requests, whatever Retry-After says", finite_number(0, 86'400));
  add_whole_number(verb, "--picture-size", options->ask.picture_size,
                   "Size of images, pixels, 64 to 2048");
  add_value(verb, "--prices", options->prices, "FILE",
            R"(Prices per million tokens: {"MODEL": {"prompt": 2.5, "answer": 10}})");
  add_value(verb, "--cache", options->cache, "DIR",
            "Folder of cached responses (default: cache/ in the output)");
  add_setting(verb, "-o,--output", options->output, "DIR",
              "Results, transcripts and cache; an interrupted run resumes");
  set_examples(verb,
               {"enfilade ask --data homes --stand-in oracle",
                "enfilade ask --endpoint http://127.0.0.1:8000/v1 --model qwen --subset 216",
                "enfilade ask --endpoint URL --model NAME --prompt marks --parallel 8 -o run",
                "enfilade ask --replay --model NAME --prompt marks --cache run/cache -o again",
                "enfilade ask --subset 216 --list"});
  verb.callback([options, &status] { status = ask(*options); });
}

}  // namespace enfilade::apps::ask_verb
