/// \file  run.json of a folder: what a run was asked for, and how it sends its requests.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "enfilade/arena/ask.h"
#include "enfilade/arena/dialect.h"

namespace enfilade::arena::detail {

using Json = nlohmann::ordered_json;

/// What a run is: what its transcripts depend on, as it is asked for. Null for answers and
/// limit_field: what the server accepts.
Json asked_json(const World& world, const Prompt& prompt, const AskConfig& config);

/// The same as it is sent: null for what is left out, and `asked` for what differs.
Json sent_json(Json run, const Dialect& dialect);

/// How the run of a folder sends its requests.
Dialect dialect_of(const Json& run);

/// The run that the folder has; no value: none, or one that has no transcript yet. It is checked
/// against what is asked for. Makes the folder of transcripts and removes unfinished files.
/// \pre this process has the folder alone
/// \throws FileError; InvalidInput for a file that is no run or is of another one
std::optional<Json> run_of(const std::filesystem::path& folder, const Json& asked);

}  // namespace enfilade::arena::detail
