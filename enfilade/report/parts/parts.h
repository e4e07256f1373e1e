/// \file  The parts of the page: each is a function that returns its JSON. Parts with pictures have
/// them as `data:` URIs, so that the page names no file.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/dataset/dataset.h"
#include "enfilade/draw/outlines.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/homes/building_plan.h"
#include "enfilade/models/training_log.h"
#include "enfilade/render/renderer.h"
#include "enfilade/report/run_directory.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::report::parts {

// With charts: chart_parts.cpp.

using Json = nlohmann::ordered_json;

/// {"missing": why}: in the place of a part. All of them take one line of the page.
Json missing(const std::string& why);

/// Counts in bins of one width.
struct Histogram {
  double width = 1;
  std::vector<std::size_t>
      counts;  ///< [0, width), [width, 2 width), ...; none beyond the last value
  std::size_t total = 0;

  void add(double value);  ///< \pre value is finite and >= 0
};
/// {"width", "total", "counts"}
Json to_json(const Histogram& histogram);

/// Lengths of paths (metres) and instructions (words) of each split, and their means.
Json lengths_part(const std::vector<tasks::Annotations>& splits,
                  const std::shared_ptr<const graph::GraphSet>& graphs);

/// The tree of the first four words of all instructions; what would be too thin to see is left out.
Json words_part(const std::vector<tasks::Annotations>& splits);

/// How far from the goal agents stop, by agent and split. "shortest" is left out: it stops there.
Json errors_part(const ScoredRuns& runs);

/// Success by the length of the shortest path, by agent and split, with intervals.
Json by_length_part(const ScoredRuns& runs);

/// Loss, navigation error and success over training, by agent, run and split.
/// \throws as models::load_training_log()
Json curves_part(const RunDirectory& found);

/// A point of a curve of the loss: the means of some records.
struct LossPoint {
  double iteration = 0;
  double loss = 0;
};
/// At most `most` points: each the mean of equally many consecutive records, the last of the rest.
/// \throws ArgumentError for 0
std::vector<LossPoint> training_curve(std::span<const models::TrainRecord> records,
                                      std::size_t most);

/// Wilson's 95 % interval of a share. \pre n > 0
struct ShareInterval {
  double low = 0, high = 0;
};
ShareInterval wilson_interval(double share, double n) noexcept;

// Buildings and pictures: picture_parts.cpp.

/// "data:image/jpeg;base64,...". \param type "image/jpeg"
std::string data_uri(std::string_view type, std::string_view bytes);

struct PictureSize {
  std::uint32_t width = 0, height = 0;
};

/// The view as a JPEG, with outlines over it; nothing if the viewpoint has no panorama.
/// \throws errors of broken pictures
std::optional<std::string> view_uri(const dataset::Dataset& data, const render::View& view,
                                    PictureSize size, std::span<const draw::Outline> outlines = {});
/// All directions, half as high as wide; the middle column is at the view's heading.
/// \param band the shown part around the horizon, from bottom to top
std::optional<std::string> panorama_uri(const dataset::Dataset& data, const render::View& view,
                                        std::uint32_t width, Radians band = degrees(180));
/// A sentence for where a picture would be. It names no folder: pages are handed around.
std::string no_pictures_of(std::string_view scan);

/// Texels along a face from which on pictures are shown first: with fewer one sees texels.
inline constexpr std::uint32_t kClearTexels = 256;
/// The scans with faces of at least kClearTexels; if there are none, all scans. A set of homes has
/// few of display quality among many for training.
std::set<ScanIndex> clear_scans(const dataset::Dataset& data);

/// The plans of a data set's buildings, each read once. One thread at a time.
class BuildingPlans {
 public:
  explicit BuildingPlans(const dataset::Dataset& data) : data_(data) {}
  /// Empty where the data set tells of nothing, also if its list is of another version of Enfilade.
  /// \throws InvalidInput for a broken file
  const homes::BuildingPlan& of(const graph::NavGraph& graph);

 private:
  dataset::Dataset data_;
  std::map<std::string, homes::BuildingPlan> plans_;  // by scan
};

/// A few paths of a split at random, those of clear_scans() first, each with its instructions and
/// the view from its start. `splits`: whole files; val_unseen is taken if it is there.
Json examples_part(const std::vector<tasks::Annotations>& splits, const dataset::Dataset& data,
                   std::size_t count);

/// The panorama of each building's viewpoint with most neighbours, of at most `most` buildings of
/// clear_scans(), spread evenly over the list.
Json panoramas_part(const dataset::Dataset& data, std::size_t most);

/// An episode of the page's gallery.
struct ChosenEpisode {
  std::string kind;         ///< "best", "worst", "random"
  std::size_t episode = 0;  ///< of the split
};

/// Floor plans with the reference path, the agent's and the goal, of these episodes of a run.
Json plans_part(const ScoredRun& run, const tasks::EpisodeSet& episodes,
                const std::vector<ChosenEpisode>& chosen, BuildingPlans& plans);

/// Maps from above of a split's episodes, with the trajectories of each agent's first run. The
/// split is val_unseen if there is a run on it. Shown are the best, worst and median episodes of
/// the last agent that is no oracle.
/// \param of_a_kind  number of episodes of each kind
Json walks_part(const ScoredRuns& runs, std::size_t of_a_kind, bool synthetic);

}  // namespace enfilade::report::parts
