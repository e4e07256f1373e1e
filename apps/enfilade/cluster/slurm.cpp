// enfilade slurm: a data job as an array of Slurm.
#include <fmt/format.h>
#include <sys/wait.h>
#include <array>
#include <cstdio>
#include <memory>
#include <string>

#include "apps/common/program.h"
#include "apps/enfilade/cluster/job.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/core/file.h"

namespace enfilade::apps {
namespace slurm_verb {
namespace {

namespace fs = std::filesystem;

struct Options {
  JobOptions job;
  std::vector<std::string> sbatch;
  bool submit = false;
};

std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::string line_of(const Words& words) {
  std::string line = quoted(own_program().string());
  for (const std::string& word : words) line += " " + quoted(word);
  return line;
}

/// As a path in an option of sbatch, which fills in what follows a %.
std::string escaped(const fs::path& path) {
  std::string text;
  for (const char c : path.string()) text += c == '%' ? std::string("%%") : std::string(1, c);
  return text;
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
  write_file_atomically(shares, share_script(options, job, folder));
  if (!job.collect.empty()) write_file_atomically(collect, collect_script(options, job, folder));
  fmt::print("{}: {} shares{}\n", shares.string(), job.shares.size(),
             job.collect.empty() ? "" : ", then " + collect.string());
  if (!options.submit) {
    fmt::print("submit:  job=$(sbatch --parsable {})\n", quoted(shares.string()));
    if (!job.collect.empty()) {
      fmt::print("         sbatch --dependency=afterok:$job --kill-on-invalid-dep=yes {}\n",
                 quoted(collect.string()));
    }
    return;
  }
  const std::string first = submit(quoted(shares.string()));
  fmt::print("submitted as job {}\n", first);
  if (job.collect.empty()) return;
  fmt::print("submitted as job {}, after it\n",
             submit(fmt::format("--dependency=afterok:{} --kill-on-invalid-dep=yes {}", first,
                                quoted(collect.string()))));
}

void add_verb(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand("slurm",
                                       "Split a data job into shards, as a job array of "
                                       "Slurm");
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

}  // namespace
}  // namespace slurm_verb

void add_slurm(CLI::App& app, int& status) { slurm_verb::add_verb(app, status); }

}  // namespace enfilade::apps
