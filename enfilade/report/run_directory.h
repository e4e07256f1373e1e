/// \file  What agents left behind: results files, model directories, their logs.
#pragma once
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/dataset/dataset.h"

namespace enfilade::report {

/// A results file and what its name says about it.
struct ResultsFile {
  std::filesystem::path file;
  std::string agent;  ///< "random", "student-2"
  std::string split;  ///< "val_unseen"
};

/// What training made: config.json, log.jsonl, results/.
struct ModelDirectory {
  std::filesystem::path folder;
  std::string agent;  ///< the folder's name: "student-2"
};

/// What was found in the folder of a run.
struct RunDirectory {
  std::vector<ResultsFile> results;    ///< shortest, random, teacher, student, others by name
  std::vector<ModelDirectory> models;  ///< likewise
};

/// "student-2" and "student" are runs of one agent, with different seeds: the name without them.
std::string_view without_seed(std::string_view agent) noexcept;

/// What is named: a results file "<agent>_<split>.json"; a model directory (a folder with
/// config.json), whose results are "results/<split>.json"; or a folder with any of these, in
/// itself, in results/ and in models/. A split is what `data` has annotations of. A file of another
/// name is passed over where a folder was named.
/// \throws FileError for what is not there; LookupError for a file whose name says no split of
/// `data`, for one agent and split in two files, or where there is nothing at all
RunDirectory find_runs(std::span<const std::filesystem::path> named, const dataset::Dataset& data);

}  // namespace enfilade::report
