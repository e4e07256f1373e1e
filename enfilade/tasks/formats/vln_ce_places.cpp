// Where VLN-CE's files lie: enfilade/tasks/continuous_episodes.h.
#include <fmt/format.h>
#include <array>
#include <span>

#include "enfilade/tasks/continuous_episodes.h"

namespace enfilade::tasks {
namespace {

using Places = std::vector<std::filesystem::path>;

// Newer versions first; of one version the one with tokens.
constexpr auto kR2rFolders =
    std::to_array<std::string_view>({"R2R_VLNCE_v1-3_preprocessed", "R2R_VLNCE_v1-3",
                                     "R2R_VLNCE_v1-2_preprocessed", "R2R_VLNCE_v1-2"});
constexpr auto kBertFolders = std::to_array<std::string_view>(
    {"R2R_VLNCE_v1-3_BERTidx", "R2R_VLNCE_v1-2_preprocessed_BERTidx"});
constexpr auto kRxrFolders =
    std::to_array<std::string_view>({"RxR_VLNCE_v0", "RxR_VLNCE_v0_enc_xlmr"});

Places places(std::span<const std::string_view> folders, std::string_view split,
              const std::string& name) {
  Places all{fmt::format("vlnce/{}", name)};
  for (const std::string_view before : {"", "data/datasets/"}) {
    for (const std::string_view folder : folders) {
      all.emplace_back(fmt::format("{}{}/{}/{}", before, folder, split, name));
    }
  }
  all.emplace_back(name);
  return all;
}

std::string_view name_of(AnnotationRole role) {
  return role == AnnotationRole::kGuide ? "guide" : "follower";
}

}  // namespace

Places continuous_places(ContinuousForm form, std::string_view split, AnnotationRole role) {
  switch (form) {
    case ContinuousForm::kR2r:
      break;
    case ContinuousForm::kR2rBert:
      return places(kBertFolders, split, fmt::format("{}_bertidx.json.gz", split));
    case ContinuousForm::kRxr:
      return places(kRxrFolders, split, fmt::format("{}_{}.json.gz", split, name_of(role)));
  }
  return places(kR2rFolders, split, fmt::format("{}.json.gz", split));
}

Places expert_places(ContinuousForm form, std::string_view split, AnnotationRole role) {
  if (form == ContinuousForm::kRxr) {
    return places(kRxrFolders, split, fmt::format("{}_{}_gt.json.gz", split, name_of(role)));
  }
  return places(kR2rFolders, split, fmt::format("{}_gt.json.gz", split));
}

}  // namespace enfilade::tasks
