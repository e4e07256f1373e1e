/// \file  Contact sheets: many small pictures with captions, and the views that they show.
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "enfilade/core/progress.h"
#include "enfilade/draw/outlines.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/image/image.h"
#include "enfilade/render/renderer.h"
#include "enfilade/scan/panorama_source.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/results.h"

namespace enfilade::draw {

/// One cell of a contact sheet.
struct SheetPicture {
  image::Image8 picture;  ///< 3 channels
  std::string caption;    ///< ASCII; may have several lines; lines that are too long are cut
};

/// How a contact sheet is laid out.
struct SheetOptions {
  std::size_t columns = 0;  ///< 0: chosen so that the sheet is about 4 : 3
  std::string title;        ///< ASCII; at the top, wrapped; may be empty
};

/// Arranges the pictures in rows, from the top left, in cells of the size of the largest.
/// \throws ArgumentError if there is no picture, one is empty or not of 3 channels, or the sheet
/// would be larger than a picture may be (image::kLongestEdge, image::kMostPixels)
image::Image8 contact_sheet(std::span<const SheetPicture> pictures,
                            const SheetOptions& options = {});

/// A view and its caption. The viewpoint by id: a store's order need not be the graph's.
struct Shot {
  std::string viewpoint;
  Radians heading, elevation;
  std::string caption;
  std::vector<Outline> outlines = {};  ///< drawn over the view
};

/// Each included viewpoint of a scan, `headings` times: at even steps from `first` on.
std::vector<Shot> shots_of_scan(const scan::PanoramaSource& source, std::size_t headings,
                                Radians first);
/// The start as annotated, then each viewpoint of the path, looking at the next one.
std::vector<Shot> shots_of_path(const graph::NavGraph& graph, const tasks::ReferencePath& path);
/// Each viewpoint of the trajectory, in the agent's direction; towards the next viewpoint if the
/// trajectory has no headings.
/// \param start heading of the first then
std::vector<Shot> shots_of_trajectory(const graph::NavGraph& graph,
                                      const tasks::Trajectory& trajectory, Radians start);

/// Adds the outlines of a goal's object (goal_outlines()) to each shot of a viewpoint that has it.
void outline_goal(std::vector<Shot>& shots, const graph::NavGraph& graph, const tasks::Goal& goal,
                  const tasks::ObjectBoxes* objects);
/// A view of the goal's object with its outline. It is from the end of the path if that sees it,
/// else from the first viewpoint that does. No value if its place is unknown.
std::optional<Shot> shot_of_goal(const graph::NavGraph& graph, const tasks::ReferencePath& path,
                                 const tasks::ObjectBoxes* objects);

/// Draws the shots, in RGB.
/// \param scan, source the shots' scan, in the renderer's set
/// \param camera of the small pictures. Each is drawn three times as large and averaged, as a small
/// picture has fewer pixels than its part of the panorama has texels
/// \throws LookupError for an unknown viewpoint or one without colour; as Renderer::render()
std::vector<SheetPicture> draw_shots(render::Renderer& renderer, ScanIndex scan,
                                     const scan::PanoramaSource& source,
                                     std::span<const Shot> shots, const Camera& camera,
                                     const Progress& progress = {});

}  // namespace enfilade::draw
