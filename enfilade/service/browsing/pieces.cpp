#include "enfilade/service/browsing/pieces.h"

#include <cstdint>
#include <filesystem>
#include <limits>
#include <unordered_map>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/tasks/files.h"

namespace enfilade::service::browsing {

// A split's file; without entries where there is none.
struct Pieces::Read {
  std::unordered_map<std::int64_t, tasks::PathAnnotation> by_path;
  bool broken = false;
};

// R2R has four splits, and the largest takes some 30 MB: none is dropped.
Pieces::Pieces(std::shared_ptr<const Site> site)
    : site_(std::move(site)),
      read_(std::numeric_limits<std::size_t>::max(),
            [](const auto& /*read*/) { return std::size_t{1}; }) {}

std::shared_ptr<const Pieces::Read> Pieces::read(const std::string& split) const {
  auto out = std::make_shared<Read>();
  try {
    for (const std::filesystem::path& place : tasks::fine_grained_places(split)) {
      const std::filesystem::path file = find_text_file(site_->folder() / place);
      if (!file_exists(file)) continue;
      tasks::Annotations annotations = tasks::load_annotations(file, split, tasks::Task::kR2r);
      for (tasks::PathAnnotation& path : annotations.paths) {
        for (tasks::InstructionDetails& details : path.details) details.tokens = {};
        const std::int64_t id = path.path_id;
        out->by_path.emplace(id, std::move(path));
      }
      break;
    }
  } catch (const Error&) {  // kept: a broken file is not read again for each request
    out->broken = true;
  }
  return out;
}

Pieces::Found Pieces::of(const PublicSplit& split, const tasks::PathAnnotation& path,
                         std::size_t k) {
  const tasks::Annotations& annotations = split.annotations;
  if (annotations.task != tasks::Task::kR2r || split.goals_hidden || path.goal_hidden()) return {};
  const auto all = read_.get(annotations.split, [&] { return read(annotations.split); });
  if (all->broken) return {{}, true};
  const auto found = all->by_path.find(path.path_id);
  if (found == all->by_path.end()) return {};
  const tasks::PathAnnotation& entry = found->second;
  const bool same = entry.scan == path.scan && entry.path == path.path &&
                    k < entry.instructions.size() && k < entry.details.size() &&
                    entry.instructions[k] == path.instructions[k];
  return same ? Found{entry.details[k].parts, false} : Found{};
}

}  // namespace enfilade::service::browsing
