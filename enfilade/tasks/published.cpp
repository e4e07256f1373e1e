#include "enfilade/tasks/published.h"

#include <algorithm>
#include <iterator>

namespace enfilade::tasks {
namespace {

constexpr std::string_view kShortest = "Shortest";
constexpr std::string_view kSeen = "val_seen", kUnseen = "val_unseen", kTest = "test";
constexpr std::string_view kNaviLlm = "README of zd11024/NaviLLM";
constexpr std::string_view kNavGpt2 = "README of GengzeZhou/NavGPT-2";
constexpr std::string_view kInternNav = "README of InternRobotics/InternNav";

// Instructions of R2R's splits.
constexpr std::size_t kOfSeen = 1020, kOfUnseen = 2349, kOfTest = 4173;

// A row of the first paper.
constexpr PublishedResult paper_row(std::string_view split, std::string_view agent, double length,
                                    double error, double success, double oracle) {
  const std::size_t episodes = split == kSeen ? kOfSeen : split == kUnseen ? kOfUnseen : kOfTest;
  return {"r2r",    split,
          agent,    kFirstPaper,
          episodes, {{{"TL", length}, {"NE", error}, {"SR", success}, {"OSR", oracle}}}};
}

// R2R's val unseen.
constexpr PublishedResult unseen_row(std::string_view agent, std::string_view source,
                                     double success, double spl) {
  return {"r2r", kUnseen, agent, source, kOfUnseen, {{{"SR", success}, {"SPL", spl}}}};
}

// The READMEs were read on 2026-11-22, InternNav's on 2026-11-30.
constexpr auto kResults = std::to_array<PublishedResult>({
    paper_row(kSeen, kShortest, 10.19, 0, 1, 1),
    paper_row(kSeen, "Random", 9.58, 9.45, 0.159, 0.214),
    paper_row(kSeen, "Seq2Seq, teacher forcing", 10.95, 8.01, 0.271, 0.367),
    paper_row(kSeen, "Seq2Seq, student forcing", 11.33, 6.01, 0.386, 0.529),
    paper_row(kUnseen, kShortest, 9.48, 0, 1, 1),
    paper_row(kUnseen, "Random", 9.77, 9.23, 0.163, 0.220),
    paper_row(kUnseen, "Seq2Seq, teacher forcing", 10.67, 8.61, 0.196, 0.291),
    paper_row(kUnseen, "Seq2Seq, student forcing", 8.39, 7.81, 0.218, 0.284),
    paper_row(kTest, "Random", 9.93, 9.77, 0.132, 0.183),
    paper_row(kTest, "Seq2Seq, student forcing", 8.13, 7.85, 0.204, 0.266),
    paper_row(kTest, "Human", 11.90, 1.61, 0.864, 0.902),
    {"r2r", kUnseen, "Speaker-Follower, greedy", "its README", kOfUnseen, {{{"SR", 0.355}}}},
    unseen_row("EnvDrop with back-translation, PyTorch 1.7.1", "README of airsplay/R2R-EnvDrop",
               0.535, 0.488),
    unseen_row("NaviLLM", kNaviLlm, 0.67, 0.59),
    unseen_row("NavGPT-2 XL", kNavGpt2, 0.6989, 0.5886),
    unseen_row("NavGPT-2 XXL", kNavGpt2, 0.7382, 0.6106),
    {"reverie", kUnseen, "NaviLLM", kNaviLlm, 0, {{{"SR", 0.4215}, {"SPL", 0.3568}}}},
    {"reverie",
     kUnseen,
     "NaviLLM without pretraining",
     kNaviLlm,
     0,
     {{{"SR", 0.4456}, {"SPL", 0.3663}}}},
    {"cvdn", kUnseen, "NaviLLM", kNaviLlm, 0, {{{"GP", 6.16}}}},
    {"soon", kUnseen, "NaviLLM", kNaviLlm, 0, {{{"SR", 0.3833}, {"SPL", 0.2924}}}},
    {"r2r-ce",
     kUnseen,
     "InternVLA-N1, DualVLN",
     kInternNav,
     0,
     {{{"NE", 4.05}, {"OSR", 0.707}, {"SR", 0.643}, {"SPL", 0.585}}}},
    {"rxr-ce",
     kUnseen,
     "InternVLA-N1, DualVLN",
     kInternNav,
     0,
     {{{"NE", 4.58}, {"SR", 0.614}, {"SPL", 0.518}, {"nDTW", 0.700}}}},
});

}  // namespace

std::optional<double> PublishedResult::value(std::string_view column) const noexcept {
  const auto found = std::ranges::find(figures, column, &PublishedFigure::column);
  return column.empty() || found == figures.end() ? std::nullopt : std::optional(found->value);
}

std::span<const PublishedResult> published_results() noexcept { return kResults; }

std::vector<PublishedResult> published_beside(const Benchmark& benchmark, std::string_view split,
                                              std::size_t episodes, bool synthetic) {
  std::vector<PublishedResult> beside;
  if (synthetic) return beside;
  std::ranges::copy_if(
      published_results(), std::back_inserter(beside), [&](const PublishedResult& one) {
        return one.benchmark == benchmark.name && one.split == split && one.agent != kShortest &&
               (one.episodes == 0 || one.episodes == episodes);
      });
  return beside;
}

}  // namespace enfilade::tasks
