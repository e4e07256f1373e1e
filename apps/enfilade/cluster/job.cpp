#include "apps/enfilade/cluster/job.h"

#include <fmt/format.h>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/common/program.h"
#include "enfilade/core/file.h"

namespace enfilade::apps {
namespace {

namespace fs = std::filesystem;

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

}  // namespace

std::string ClusterJob::to_json() const {
  return nlohmann::ordered_json{{"program", own_program().string()},
                                {"cwd", fs::current_path().string()},
                                {"shares", shares},
                                {"collect", collect}}
             .dump(1) +
         "\n";
}

fs::path shard_file(const fs::path& file, const Shard& shard) {
  if (shard.count == 1) return file;
  fs::path own = file;
  own.replace_filename(fmt::format("{}.{}-of-{}{}", file.stem().string(), shard.index + 1,
                                   shard.count, file.extension().string()));
  return own;
}

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

ClusterJob job_of_commands(const fs::path& file) {
  const std::string text = read_file(file);
  ClusterJob job;
  std::size_t number = 0;
  const auto refuse = [&](const char* code, const char* what) {
    throw InvalidInput(
        {{Severity::kError, file.string(), fmt::format("line {}", number), code, what}});
  };
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    at = end + 1;
    ++number;
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') continue;
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

void add_job_options(CLI::App& verb, JobOptions& options) {
  verb.prefix_command();
  add_whole_number(verb, "--shards", options.shards, "Number of shards");
  add_value(verb, "--commands", options.commands, "FILE",
            "File of commands, one per line and shard, instead of a verb");
  add_setting(verb, "-o,--output", options.folder, "DIR",
              "Scripts, logs and state; on a file system that all machines share");
  add_whole_number(verb, "--cpus", options.cpus, "Processors per shard");
}

ClaimedJob claim_job(const CLI::App& verb, const JobOptions& options) {
  const Words words = verb.remaining();
  if (!options.commands.empty() && !words.empty()) {
    throw UsageError(fmt::format("--commands, {}: one of them", words.front()));
  }
  ClaimedJob claimed{options.commands.empty() ? job_of_verb(words, options.shards)
                                              : job_of_commands(options.commands),
                     fs::absolute(options.folder).lexically_normal()};
  make_folder(claimed.folder / "done");
  make_folder(claimed.folder / "logs");
  const fs::path file = claimed.folder / "plan.json";
  const std::string plan = claimed.job.to_json();
  if (file_exists(file) && read_file(file) != plan) {
    throw UsageError(
        fmt::format("{}: holds another job; give another folder, or repeat that job's command",
                    claimed.folder.string()));
  }
  write_file_atomically(file, plan);
  return claimed;
}

}  // namespace enfilade::apps
