#include "apps/enfilade/learning/learn.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <cstdio>
#include <cstring>
#include <system_error>
#include <utility>

#include "apps/common/program.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/output_folder.h"

namespace enfilade::apps {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

// The published sizes and optimisers suit 14,000 instructions and a day's training; these suit a
// few thousand and a minute. Walking behind the teacher alone teaches most in the first minutes.
const Words kPanoramic = {"--agent",          "panoramic", "--recipe",     "small",
                          "--feedback",       "teacher",   "--iterations", "600",
                          "--evaluate-every", "300",       "--seed",       "1"};

bool is_newer(const fs::path& file, const fs::path& than) {
  std::error_code code;
  const auto made = fs::last_write_time(file, code);
  return !code && made >= fs::last_write_time(than, code) && !code;
}

class Lesson {
 public:
  Lesson(fs::path homes, fs::path output) : homes_(std::move(homes)), output_(std::move(output)) {}

  int run() {
    const fs::path encoder = output_ / "encoder.safetensors";
    const fs::path features = output_ / "features.safetensors";
    forget_other_homes({encoder, features});
    make(encoder, homes_ / "homes.json", {"pretrain", "--pictures", "3500"});
    make(features, encoder, {"features", "--encoder", "home", "--weights", encoder.string()});
    train("panoramic", features, kPanoramic);
    step({"table", output_.string(), "--data", homes_.string()});
    step({"report", output_.string(), "--data", homes_.string(), "-o",
          (output_ / "report.html").string()});
    return status_;
  }

 private:
  void step(const Words& words) {
    if (status_ == 0) status_ = run_step(words);
  }

  // What was learnt in other homes may be newer than these, so that times tell nothing.
  void forget_other_homes(const std::vector<fs::path>& learnt) {
    const fs::path learnt_from = output_ / "learnt_from.json";
    const std::string homes = read_file(homes_ / "homes.json");
    if (fs::exists(learnt_from) && read_file(learnt_from) == homes) return;
    const OutputFolder out(output_);
    for (const fs::path& file : learnt) {
      if (fs::exists(file)) {
        out.remove(file.filename().string());
        say("\n{} was learnt in other homes: removed, to be made again\n", file.string());
      }
    }
    out.write("learnt_from.json", homes);
  }

  // As make does: nothing, if the file is there and newer than what it is made of.
  void make(const fs::path& file, const fs::path& from, Words words) {
    if (is_newer(file, from)) {
      say("\n{} is there, made by an earlier demo\n", file.string());
      return;
    }
    const Words rest{"--data", homes_.string(), "-o", file.string()};
    words.insert(words.end(), rest.begin(), rest.end());
    step(words);
  }

  void train(const std::string& name, const fs::path& features, const Words& recipe) {
    const fs::path model = output_ / "models" / name;
    if (status_ == 0 && fs::exists(model) && !is_newer(model / "config.json", features)) {
      say("\n{} was trained on other features: removed, to be trained again\n", model.string());
      OutputFolder(output_).remove_all("models/" + name);
    }
    Words words{"train",           "--data", homes_.string(), "--features",
                features.string(), "-o",     model.string()};
    words.insert(words.end(), recipe.begin(), recipe.end());
    step(words);
  }

  fs::path homes_, output_;
  int status_ = 0;
};

}  // namespace

int run_step(const std::vector<std::string>& words) {
  say("\n$ enfilade {}\n", fmt::join(words, " "));
  std::fflush(stdout);
  std::vector<std::string> command{own_program().string()};
  command.insert(command.end(), words.begin(), words.end());
  const Stopwatch clock;
  const int status = run_command(command);
  if (status < 0) {
    throw FileError(fmt::format("{}: cannot be started: {}", command[0], std::strerror(-status)));
  }
  if (status == 0) say("({:.0f} s)\n", clock.seconds());
  return status;
}

int learn_in_homes(const fs::path& homes, const fs::path& output) {
  return Lesson(homes, output).run();
}

}  // namespace enfilade::apps
