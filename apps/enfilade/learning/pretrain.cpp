// enfilade pretrain: a small image encoder, trained on what the renderer says is to be seen.
#include "enfilade/neural/pretrain.h"

#include <fmt/format.h>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "apps/common/program.h"
#include "apps/enfilade/learning/learn.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/mesh/mpcat40.h"
#include "enfilade/neural/device.h"

namespace enfilade::apps::pretrain_verb {
namespace {

struct Options {
  std::string data, output = "home_encoder.safetensors", probe;
  neural::PretrainConfig config;
};

std::set<std::string> scans_of(const dataset::Dataset& data, const std::string& split) {
  std::set<std::string> scans;
  for (const auto& path : data.annotations(split).paths) scans.insert(path.scan);
  return scans;
}

// The homes that agents train in, and no others; val unseen's to be tried on.
void set_scans(const dataset::Dataset& data, neural::PretrainConfig& config) {
  const std::set<std::string> training = scans_of(data, "train");
  std::set<std::string> unseen = scans_of(data, "val_unseen");
  for (const std::string& scan : training) unseen.erase(scan);
  config.training.assign(training.begin(), training.end());
  config.unseen.assign(unseen.begin(), unseen.end());
}

// Model homes come with a list that says which room each viewpoint stands in.
void set_rooms(const dataset::Dataset& data, neural::PretrainConfig& config) {
  if (!std::filesystem::exists(data.folder() / "homes.json")) return;
  std::map<std::pair<std::string, std::string>, char> rooms;
  for (const homes::HomeEntry& home : homes::read_home_list(data.folder())) {
    for (const homes::RoomEntry& room : home.rooms) {
      for (const std::string& viewpoint : room.viewpoints) {
        rooms[{home.scan, viewpoint}] = room.type;
      }
    }
  }
  config.room = [rooms = std::move(rooms)](const std::string& scan, const std::string& viewpoint) {
    const auto found = rooms.find({scan, viewpoint});
    return found == rooms.end() ? '-' : found->second;
  };
}

// A line now and then, for logs too.
neural::PretrainProgress loss_lines() {
  return [next = std::size_t{0}, sum = 0.0, n = 0](std::size_t step, std::size_t steps,
                                                   double loss) mutable {
    constexpr std::size_t kLines = 10;
    sum += loss;
    ++n;
    if (step * kLines < (next + 1) * steps && step != steps) return;
    say(stderr, "pretrain: step {} of {}, loss {:.3f}\n", step, steps, sum / n);
    next = step * kLines / steps;
    sum = 0;
    n = 0;
  };
}

std::string percent(double value) {
  return std::isnan(value) ? "-" : fmt::format("{:.1f}", 100 * value);
}

void print_report(const neural::PretrainReport& report) {
  say("{} pictures drawn in {:.1f} s; {} parameters, {} steps in {:.1f} s; loss {:.3f}\n\n",
      report.pictures, report.drawing_seconds, report.parameters, report.steps,
      report.training_seconds, report.loss);
  say("{:<34}{:>14}{:>14}\n", "on pictures not trained on, %", "homes trained", "unseen homes");
  const auto line = [](std::string_view name, const std::string& seen, const std::string& unseen) {
    say("{:<34}{:>14}{:>14}\n", name, seen, unseen);
  };
  const neural::HomeScore &seen = report.seen, &unseen = report.unseen;
  line("pictures", fmt::format("{}", seen.pictures), fmt::format("{}", unseen.pictures));
  const auto shares = [&](std::string_view name, const auto& of) {
    line(name, percent(of(seen)), percent(of(unseen)));
  };
  shares("mean average precision", [](const auto& score) { return score.mean_average_precision; });
  shares("  guessing", [](const auto& score) { return score.chance; });
  shares("room named right", [](const auto& score) { return score.rooms; });
  shares("distance off by", [](const auto& score) { return std::expm1(score.distance_error); });
  for (std::size_t i = 0; i < report.classes.size(); ++i) {
    const auto name = mesh::class_name(static_cast<std::size_t>(report.classes[i]));
    shares(fmt::format("  {}", name), [i](const auto& score) {
      const std::vector<double>& all = score.average_precision;
      return i < all.size() ? all[i] : std::nan("");
    });
  }
}

void print_probe(const neural::ProbeReport& report) {
  say("{} numbers a view; fitted at {} viewpoints, scored at {} of unseen homes; {} classes\n\n",
      report.dimensions, report.training, report.unseen, report.classes);
  say("{:<48}{:>8}{:>10}\n", "what a linear probe reads from a view", "", "guessing");
  const auto line = [](std::string_view name, const std::string& score, const std::string& chance) {
    say("{:<48}{:>8}{:>10}\n", name, score, chance);
  };
  line("classes in the view, mean average precision, %", percent(report.view_precision),
       percent(report.view_chance));
  line("classes in each third of it", percent(report.third_precision),
       percent(report.third_chance));
  line("room named right, %", percent(report.room), percent(report.room_chance));
  line("  from all views of a viewpoint", percent(report.viewpoint_room),
       percent(report.room_chance));
  line("ln distance of the thirds, mean error", fmt::format("{:.3f}", report.distance_error),
       fmt::format("{:.3f}", report.distance_chance));
}

void probe(const Options& o, const std::shared_ptr<const scan::PanoramaSet>& panoramas) {
  const neural::ProbeConfig config{.training = o.config.training,
                                   .unseen = o.config.unseen,
                                   .room = o.config.room,
                                   .threads = o.config.threads};
  print_probe(neural::probe_features(features::FeatureSet::open(o.probe), panoramas, config));
}

void run(Options o) {
  neural::set_threads(o.config.threads);
  const dataset::Dataset data = open_data(o.data);
  set_scans(data, o.config);
  set_rooms(data, o.config);
  std::vector<std::string> scans = o.config.training;
  scans.insert(scans.end(), o.config.unseen.begin(), o.config.unseen.end());
  const auto panoramas = scan::PanoramaSet::open(data.panorama_places(), std::move(scans));
  if (!o.probe.empty()) return probe(o, panoramas);
  const auto report = neural::pretrain_home_encoder(panoramas, o.config, o.output, loss_lines());
  say("{}\n", o.output);
  print_report(report);
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand("pretrain", kPretrainHelp);
  const auto options = std::make_shared<Options>();
  add_data_option(verb, options->data);
  add_setting(verb, "-o,--output", options->output, "FILE",
              "Weights, for `enfilade features --weights`");
  add_whole_number(verb, "--pictures", options->config.pictures,
                   "Approximate number of training pictures");
  add_whole_number(verb, "--epochs", options->config.epochs, "Passes over the pictures");
  add_whole_number(verb, "--seed", options->config.seed, "The same seed gives the same network", 0);
  add_setting(verb, "--device", options->config.device, "NAME", "cpu, cuda or cuda:N");
  add_value(verb, "--probe", options->probe, "FEATURES",
            "Only score a feature file, by a linear probe in unseen homes");
  add_threads_option(verb, options->config.threads,
                     "0: all cores; another number gives another network");
  set_examples(verb, {"enfilade pretrain --data homes",
                      "enfilade pretrain --data homes --epochs 6 -o better.safetensors",
                      "enfilade pretrain --data homes --probe features.safetensors"});
  verb.callback([options] { run(*options); });
}

}  // namespace enfilade::apps::pretrain_verb
