/// \file  Malformed inputs and what each gets: one table, run against the real program, from which
/// docs/bad_input.md is written too.
#pragma once
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace enfilade::bad_input {

/// A data set as files: two buildings, their regions and annotations, and a results file, all good.
/// A case breaks one thing in it.
class Files {
 public:
  Files();
  /// Replaces the first `from` in a file; a case whose `from` is not there is a broken case.
  Files& edit(const std::string& file, const std::string& from, const std::string& to);
  Files& write(const std::string& file, const std::string& content);
  Files& remove(const std::string& file);
  Files& append(const std::string& file, const std::string& content);
  const std::string& content(const std::string& file) const;
  const std::vector<std::pair<std::string, std::string>>& all() const { return files_; }

 private:
  std::string& find(const std::string& file);
  std::vector<std::pair<std::string, std::string>> files_;  // path in the data set, content
};

inline constexpr const char* kGraph = "connectivity/one_connectivity.json";
inline constexpr const char* kScans = "connectivity/scans.txt";
inline constexpr const char* kAnnotations = "r2r/R2R_made.json";
inline constexpr const char* kRegions = "regions/region_to_panorama.json";
inline constexpr const char* kResults = "results.json";

/// The content of a file that is a pipe, which no program writes to.
inline constexpr const char* kPipe = "<a pipe>";
/// ASCII as Windows' editors save "Unicode": little-endian, with a byte-order mark.
std::string utf16(std::string_view ascii);
/// A level square of 4 m, z up, as HM3D's files are: binary glTF.
std::string glb_of_hm3d();

struct Case {
  std::string group;    ///< heading in the docs: "Graphs"
  std::string input;    ///< what is wrong, in words
  std::string command;  ///< arguments of `enfilade`; {} stands for the data set's folder
  int exit_code = 0;
  std::string says;  ///< part of what is printed; {} as above
  std::function<void(Files&)> damage;
  bool learns = false;     ///< needs the program with networks
  std::string first = {};  ///< a command that is run before, and succeeds; empty: none
  bool asks = false;       ///< needs the program that speaks HTTP
};

std::vector<Case> arena_cases();
std::vector<Case> graph_cases();
std::vector<Case> mesh_cases();
std::vector<Case> annotation_cases();
std::vector<Case> result_cases();
std::vector<Case> task_cases();
std::vector<Case> free_walk_cases();
std::vector<Case> render_cases();
std::vector<Case> command_line_cases();
std::vector<Case> import_cases();
std::vector<Case> home_cases();
std::vector<Case> weight_cases();
std::vector<Case> all_cases();

struct Outcome {
  int exit_code = 0;            ///< 128 + signal if the program was killed
  std::string output;           ///< stdout and stderr, the data set's folder written as {}
  std::size_t most_memory = 0;  ///< bytes
  double work = 0;              ///< seconds of processors' time
};
/// Lays the files out in a fresh folder and runs the program on them.
Outcome run(const Case& one);

/// The docs page that the cases make.
std::string docs_page();

}  // namespace enfilade::bad_input
