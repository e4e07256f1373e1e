/// \file  The parts of the page that show buildings (examples, panoramas, floor plans), and
/// pictures as `data:` URIs: the page names no file.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/dataset/dataset.h"
#include "enfilade/draw/outlines.h"
#include "enfilade/render/renderer.h"
#include "enfilade/report/scored_runs.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::report::parts {

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

/// A few paths of a split at random, each with its instructions and the view from its start.
/// `splits`: whole files; val_unseen is taken if it is there.
nlohmann::ordered_json examples_part(const std::vector<tasks::Annotations>& splits,
                                     const dataset::Dataset& data, std::size_t count);

/// The panorama of each building's viewpoint with most neighbours, of at most `most` buildings,
/// spread evenly over the list.
nlohmann::ordered_json panoramas_part(const dataset::Dataset& data, std::size_t most);

/// An episode of the page's gallery.
struct ChosenEpisode {
  std::string kind;         ///< "best", "worst", "random"
  std::size_t episode = 0;  ///< of the split
};

/// Floor plans with the reference path, the agent's and the goal, of these episodes of a run.
nlohmann::ordered_json plans_part(const ScoredRun& run, const tasks::EpisodeSet& episodes,
                                  const std::vector<ChosenEpisode>& chosen);

}  // namespace enfilade::report::parts
