/// \file  Transcripts walked again: where each step stood, and the pictures that were sent there.
/// Transcripts have neither, so their calls are repeated in a session of the same episode.
#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "enfilade/arena/pictures.h"
#include "enfilade/arena/session.h"
#include "enfilade/service/sessions/run_folder.h"
#include "enfilade/service/sessions/transcripts.h"
#include "enfilade/service/site.h"

namespace enfilade::service::sessions {

/// Called at each step before its call, and once at the end, whose number is that of the steps.
/// \returns whether to go on
using AtStep = std::function<bool(std::size_t step, const arena::GraphSession& session,
                                  const graph::NavGraph& graph)>;

/// Repeats the calls of a transcript.
/// \param at_step not called from the first step on that comes out differently from the transcript
/// \returns that step, from 1; 0: none
/// \throws as arena::GraphWorld, and what at_step throws
std::size_t walk_again(const std::shared_ptr<const Site>& site, const EpisodePlace& place,
                       const Transcript& transcript, const AtStep& at_step);

/// Adds the scan to `out`. Each step gets its place ("at") and the captions of its pictures
/// ("pictures"), as far as that is known.
/// \returns why the places of some steps are not known; empty: they are all known
std::string add_places(const std::shared_ptr<const Site>& site, const Run& run,
                       std::string_view episode, Transcript& transcript,
                       nlohmann::ordered_json& out);

/// The pictures of a step, as they were sent, in their order. Empty if this site would draw others.
/// \param pixels their size
std::vector<arena::PictureOrder> pictures_sent(const Site& site, const TranscriptStep& step,
                                               const arena::GraphSession& session,
                                               std::uint32_t pixels);

}  // namespace enfilade::service::sessions
