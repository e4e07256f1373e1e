/// \file  The names that short programs use, in one include and without their folders.
///
///     #include <enfilade/enfilade.h>
///     using namespace enfilade;
///
/// Programs of more than a page do better with the headers of the folders that they use.
#pragma once

#include "enfilade/agents/run.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/dataset/views.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/image/codecs.h"
#include "enfilade/render/renderer.h"
#include "enfilade/sim/candidates.h"
#include "enfilade/sim/simulator.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade {

using agents::Agent;
using agents::Decision;
using agents::make_agent;
using agents::Observation;
using agents::run_agent;
using dataset::Dataset;
using dataset::NamedView;
using dataset::render_colour;
using dataset::render_depth;
using dataset::render_panorama;
using image::save;
using sim::Action;
using sim::EpisodeStart;
using sim::Simulator;
using sim::SimulatorConfig;
using tasks::compute_score;
using tasks::load_results;

}  // namespace enfilade
