// enfilade slurm and enfilade ray: data jobs that many machines share, cut into shards here and run
// by an engine that exists.
#include <fmt/format.h>
#include <sys/wait.h>
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/core/file.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/core/written_lists.h"

namespace enfilade::apps {
namespace {

namespace fs = std::filesystem;

/// The words of a command, without the program.
using Words = std::vector<std::string>;

/// A job. Shards may run in any order and on any computer with the same files; their output
/// equals that of one computer.
struct ClusterJob {
  std::vector<Words> shares;
  Words collect = {};  ///< once all shares are done; empty: nothing is left to do
};

/// Options of the verbs of all engines.
struct JobOptions {
  std::size_t shards = 16, cpus = 1;
  std::string folder = "job", commands;
};

/// A job in its folder. FOLDER/plan.json describes it, and FOLDER/done has a file for each finished
/// shard, so that a restarted job does only the others.
struct ClaimedJob {
  ClusterJob job;
  std::filesystem::path folder;  ///< absolute
};

/// The value of an option among words, as CLI11 reads them: "-o x", "-ox", "--output x",
/// "--output=x".
std::optional<std::string> value_of(const Words& words, char letter, std::string_view name) {
  const std::string short_name{'-', letter}, long_name = fmt::format("--{}", name);
  for (std::size_t k = 0; k < words.size(); ++k) {
    const std::string& word = words[k];
    if ((word == short_name || word == long_name) && k + 1 < words.size()) return words[k + 1];
    if (word.starts_with(long_name + "=")) return word.substr(long_name.size() + 1);
    if (word.starts_with(short_name) && word.size() > 2) return word.substr(2);
  }
  return std::nullopt;
}

bool has_open_quote(std::string_view line) {
  char open = 0;
  for (const char c : line) {
    if (c == open) {
      open = 0;
    } else if (open == 0 && (c == '"' || c == '\'' || c == '`')) {
      open = c;
    }
  }
  return open != 0;
}

Words merging(const Words& words, std::size_t shards) {
  const auto output = value_of(words, 'o', "output");
  if (!output) throw UsageError("features: -o FILE is needed");
  Words merge{"features", "--merge"};
  for (std::size_t k = 0; k < shards; ++k) {
    merge.push_back(shard_file(*output, {k, shards}).string());
  }
  merge.insert(merge.end(), {"-o", *output});
  if (std::ranges::find(words, "--float16") != words.end()) merge.emplace_back("--float16");
  return merge;
}

// What engines read.
std::string to_json(const ClusterJob& job) {
  return nlohmann::ordered_json{{"program", own_program().string()},
                                {"cwd", fs::current_path().string()},
                                {"shares", job.shares},
                                {"collect", job.collect}}
             .dump(1) +
         "\n";
}

/// The shards of a verb. \param words  "features", "--data", ...: a verb that has --shard
ClusterJob job_of_verb(const Words& words, std::size_t shards) {
  if (words.empty()) {
    throw UsageError("a verb is needed, such as: features --weights FILE -o FILE; or --commands");
  }
  const bool known = words.front() == "features" || words.front() == "homes";
  if (!known) {
    throw UsageError(fmt::format(
        "{:?}: features and homes can be cut into shares; write other commands into a file, a line "
        "each, and give --commands FILE",
        words.front()));
  }
  for (const char* name : {"--shard", "--merge"}) {
    if (std::ranges::any_of(words, [name](const std::string& w) { return w.starts_with(name); })) {
      throw UsageError(fmt::format("{}: it is set for each share here; leave it out", name));
    }
  }
  ClusterJob job;
  if (shards == 1) {
    job.shares.push_back(words);
    return job;
  }
  for (std::size_t k = 1; k <= shards; ++k) {
    Words share = words;
    share.insert(share.end(), {"--shard", fmt::format("{}/{}", k, shards)});
    job.shares.push_back(std::move(share));
  }
  job.collect = words.front() == "homes" ? words : merging(words, shards);
  return job;
}

/// A job of a file's lines, one command each, without the word `enfilade`. Blank lines and those
/// with # are skipped.
ClusterJob job_of_commands(const fs::path& file) {
  const std::string text = read_plain_text(file);
  ClusterJob job;
  std::size_t number = 0;
  const auto refuse = [&](const char* code, const char* what) {
    throw InvalidInput(
        {{Severity::kError, file.string(), fmt::format("line {}", number), code, what}});
  };
  for (const ListLine& one : list_lines(text)) {
    number = one.number;
    const std::string line(one.text);
    if (has_open_quote(line)) refuse("open-quote", "a quote without an end");
    Words words = CLI::detail::split_up(line);
    std::erase_if(words, [](const std::string& word) { return word.empty(); });
    for (std::string& word : words) CLI::detail::remove_quotes(word);
    if (words.front() == "enfilade") words.erase(words.begin());
    if (words.empty()) refuse("no-verb", "no verb behind enfilade");
    job.shares.push_back(std::move(words));
  }
  if (job.shares.empty()) refuse("no-command", "there is no command in it");
  return job;
}

/// To a verb whose other words are those of the sharded verb.
void add_job_options(CLI::App& verb, JobOptions& options) {
  verb.prefix_command();
  add_whole_number(verb, "--shards", options.shards, "Number of shards");
  add_value(verb, "--commands", options.commands, "FILE",
            "File of commands, one per line and shard, instead of a verb");
  add_setting(verb, "-o,--output", options.folder, "DIR",
              "Scripts, logs and state; on a file system that all machines share");
  add_whole_number(verb, "--cpus", options.cpus, "Processors per shard");
}

/// Makes the folder. \pre the verb was parsed
ClaimedJob claim_job(const CLI::App& verb, const JobOptions& options) {
  const Words words = verb.remaining();
  if (!options.commands.empty() && !words.empty()) {
    throw UsageError(fmt::format("--commands, {}: one of them", words.front()));
  }
  ClaimedJob claimed{options.commands.empty() ? job_of_verb(words, options.shards)
                                              : job_of_commands(options.commands),
                     fs::absolute(options.folder).lexically_normal()};
  const OutputFolder out(claimed.folder);
  for (const char* folder : {"done", "logs"}) static_cast<void>(out.folder(folder));
  const fs::path file = claimed.folder / "plan.json";
  const std::string plan = to_json(claimed.job);
  if (file_exists(file) && read_file(file) != plan) {
    throw UsageError(
        fmt::format("{}: holds another job; give another folder, or repeat that job's command",
                    claimed.folder.string()));
  }
  out.write("plan.json", plan);
  return claimed;
}

}  // namespace

namespace slurm_verb {
namespace {

struct Options {
  JobOptions job;
  std::vector<std::string> sbatch;
  bool submit = false;
};

std::string quoted(const std::string& word) {
  return "'" + CLI::detail::find_and_replace(word, "'", "'\\''") + "'";
}

std::string line_of(const Words& words) {
  std::string line = quoted(own_program().string());
  for (const std::string& word : words) line += " " + quoted(word);
  return line;
}

/// As a path in an option of sbatch, which fills in what follows a %.
std::string escaped(const fs::path& path) {
  return CLI::detail::find_and_replace(path.string(), "%", "%%");
}

/// \param log in logs/ of the job's folder, with the patterns of sbatch
std::string head_of(const Options& options, const std::string& name, const fs::path& folder,
                    const std::string& log) {
  std::string head = fmt::format(
      "#!/bin/bash\n"
      "#SBATCH --job-name=enfilade-{}\n"
      "#SBATCH --cpus-per-task={}\n"
      "#SBATCH --output=\"{}/logs/{}\"\n"
      "#SBATCH --requeue\n",
      name, options.job.cpus, escaped(folder), log);
  for (const std::string& one : options.sbatch) head += "#SBATCH " + one + "\n";
  return head;
}

/// An array with a task a share; one that is done already ends at once.
std::string share_script(const Options& options, const ClusterJob& job, const fs::path& folder) {
  std::string script = head_of(options, job.shares.front().front(), folder, "%a.log");
  script += fmt::format(
      "#SBATCH --array=1-{}\n"
      "# Made by `enfilade slurm`. Submitted again, it does what is not done.\n"
      "set -eu\n"
      "cd {}\n"
      "share=${{SLURM_ARRAY_TASK_ID:?this script is a job array: submit it with sbatch}}\n"
      "done={}/$share\n"
      "if [ -e \"$done\" ]; then exit 0; fi\n"
      "case $share in\n",
      job.shares.size(), quoted(fs::current_path().string()), quoted((folder / "done").string()));
  for (std::size_t k = 0; k < job.shares.size(); ++k) {
    script += fmt::format("  {}) {} ;;\n", k + 1, line_of(job.shares[k]));
  }
  return script + "esac\ntouch \"$done\"\n";
}

std::string collect_script(const Options& options, const ClusterJob& job, const fs::path& folder) {
  return head_of(options, "collect", folder, "collect.log") +
         fmt::format(
             "# Made by `enfilade slurm`: once all shares are done.\n"
             "set -eu\n"
             "cd {}\n"
             "for share in $(seq {}); do\n"
             "  [ -e {}/\"$share\" ] || {{ echo \"share $share is not done\" >&2; exit 1; }}\n"
             "done\n"
             "{}\n",
             quoted(fs::current_path().string()), job.shares.size(),
             quoted((folder / "done").string()), line_of(job.collect));
}

/// \returns the job's number, as --parsable gives it
std::string submit(const std::string& words) {
  const std::string command = "sbatch --parsable " + words + " 2>&1";
  std::string said;
  FILE* const pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) throw Error("sbatch: cannot be started");
  std::array<char, 256> part{};
  while (std::fgets(part.data(), part.size(), pipe) != nullptr) said += part.data();
  const int status = pclose(pipe);
  while (said.ends_with('\n')) said.pop_back();
  constexpr int kNotFound = 127;
  if (WIFEXITED(status) && WEXITSTATUS(status) == kNotFound) {
    throw UsageError(
        "--submit: there is no sbatch on this machine; submit the scripts where Slurm is");
  }
  if (status != 0) throw Error(fmt::format("sbatch {}: {}", words, said));
  return said.substr(0, said.find(';'));
}

void run(const CLI::App& verb, const Options& options) {
  const auto [job, folder] = claim_job(verb, options.job);
  const fs::path shares = folder / "shares.sbatch", collect = folder / "collect.sbatch";
  const OutputFolder out(folder);
  out.write("shares.sbatch", share_script(options, job, folder));
  if (!job.collect.empty()) out.write("collect.sbatch", collect_script(options, job, folder));
  say("{}: {} shares{}\n", shares.string(), job.shares.size(),
      job.collect.empty() ? "" : ", then " + collect.string());
  if (!options.submit) {
    say("submit:  job=$(sbatch --parsable {})\n", quoted(shares.string()));
    if (!job.collect.empty()) {
      say("         sbatch --dependency=afterok:$job --kill-on-invalid-dep=yes {}\n",
          quoted(collect.string()));
    }
    return;
  }
  const std::string first = submit(quoted(shares.string()));
  say("submitted as job {}\n", first);
  if (job.collect.empty()) return;
  say("submitted as job {}, after it\n",
      submit(fmt::format("--dependency=afterok:{} --kill-on-invalid-dep=yes {}", first,
                         quoted(collect.string()))));
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb =
      *app.add_subcommand("slurm", "Split a data job into shards, as a job array of Slurm");
  const auto options = std::make_shared<Options>();
  add_job_options(verb, options->job);
  add_value(verb, "--sbatch", options->sbatch, "OPTION",
            "Options for sbatch, such as --sbatch=--time=2:00:00; may be repeated")
      ->allow_extra_args(false);
  verb.add_flag("--submit", options->submit, "Submit the job with sbatch");
  set_examples(verb,
               {"enfilade slurm --shards 16 homes -o homes --preset full",
                "enfilade slurm --shards 32 --cpus 8 --sbatch=--partition=cpu --submit features "
                "--data homes --weights resnet152.pth -o features.safetensors",
                "enfilade slurm --commands evaluations.txt -o evaluations"});
  verb.callback([options, &verb] { run(verb, *options); });
}

}  // namespace slurm_verb

namespace ray_verb {
namespace {

struct Options {
  JobOptions job;
  std::size_t attempts = 5;
  std::string address, python = "python3";
};

void run(const CLI::App& verb, const Options& options) {
  const std::filesystem::path folder = claim_job(verb, options.job).folder;
  std::vector<std::string> words{options.python,     "-m",
                                 "enfilade.cluster", folder.string(),
                                 "--cpus",           std::to_string(options.job.cpus),
                                 "--attempts",       std::to_string(options.attempts)};
  if (!options.address.empty()) words.insert(words.end(), {"--address", options.address});
  throw UsageError(fmt::format("ray: {}: {}; --python names another", options.python,
                               std::strerror(become(options.python, words))));
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand("ray", "Run a data job in shards, as tasks of Ray");
  const auto options = std::make_shared<Options>();
  add_job_options(verb, options->job);
  add_whole_number(verb, "--attempts", options->attempts, "Most attempts per shard");
  add_value(verb, "--address", options->address, "ADDRESS",
            "Address of a running cluster: auto, or HOST:PORT (default: one on this machine "
            "alone)");
  add_setting(verb, "--python", options->python, "PROGRAM",
              "Python with the packages enfilade and ray");
  set_examples(verb, {"enfilade ray --shards 16 homes -o homes --preset full",
                      "enfilade ray --address auto --cpus 8 features --data homes --weights "
                      "resnet152.pth -o features.safetensors",
                      "enfilade ray --commands evaluations.txt -o evaluations"});
  verb.callback([options, &verb] { run(verb, *options); });
}

}  // namespace ray_verb

}  // namespace enfilade::apps
