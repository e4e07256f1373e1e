#include "enfilade/tasks/r4r.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <string_view>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/threads.h"
#include "enfilade/core/utf8.h"

namespace enfilade::tasks {
namespace {

void check_options(const JoinOptions& options) {
  if (options.paths < 2) {
    throw ArgumentError(fmt::format("{} paths to join; at least 2 are needed", options.paths));
  }
  if (!std::isfinite(options.most_gap) || options.most_gap < 0) {
    throw ArgumentError(
        fmt::format("a gap of {} m at most; a finite number from 0 is allowed", options.most_gap));
  }
}

void check_paths(const std::vector<PathAnnotation>& paths) {
  for (const PathAnnotation& path : paths) {
    if (path.goal_hidden() || path.path.empty()) {
      throw ArgumentError(
          fmt::format("path {}: its goal is hidden; nothing can be joined to it", path.path_id));
    }
    if (!path.distance) {
      throw ArgumentError(
          fmt::format("path {}: has no distance, which joined ones are sums of", path.path_id));
    }
  }
}

// The paths of one scan, as indices into the input.
struct PathsOfScan {
  ScanIndex scan;
  std::vector<std::size_t> members;
};

// Scans in the order in which they first appear.
std::vector<PathsOfScan> by_scan(const std::vector<ReferencePath>& paths, std::size_t scans) {
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::vector<PathsOfScan> groups;
  std::vector<std::size_t> group_of(scans, kNone);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    std::size_t& group = group_of[paths[i].scan.at()];
    if (group == kNone) {
      group = groups.size();
      groups.push_back({paths[i].scan, {}});
    }
    groups[group].members.push_back(i);
  }
  return groups;
}

// Joins the paths of one scan.
class Joiner {
 public:
  Joiner(const std::vector<PathAnnotation>& entries, const std::vector<ReferencePath>& paths,
         const graph::NavGraph& graph, const JoinOptions& options)
      : entries_(entries), paths_(paths), graph_(graph), options_(options) {}

  // Sequences of JoinOptions::paths paths, as indices one after another.
  // \param looked_at  gets how many there were to choose from
  std::vector<std::size_t> sequences(const std::vector<std::size_t>& members,
                                     std::size_t& looked_at) const {
    std::vector<std::size_t> all = members;
    for (std::size_t length = 1; length < options_.paths; ++length) {
      looked_at = all.size() / length * members.size();
      all = extended(all, length, members);
    }
    return all;
  }

  JoinedPath path_of(std::span<const std::size_t> sequence) const {
    const PathAnnotation& first = entries_[sequence.front()];
    JoinedPath joined;
    joined.path.scan = first.scan;
    joined.path.heading = first.heading;
    joined.path.instructions = first.instructions;
    joined.from.push_back(first.path_id);
    double distance = *first.distance;
    std::vector<ViewpointIndex> walk = paths_[sequence.front()].viewpoints;
    for (const std::size_t i : sequence.subspan(1)) {
      const PathAnnotation& next = entries_[i];
      const std::vector<ViewpointIndex>& viewpoints = paths_[i].viewpoints;
      // In the generator's order: sums of floating-point numbers depend on it.
      distance = distance + graph_.distance(walk.back(), viewpoints.front()) + *next.distance;
      const std::vector<ViewpointIndex> between = shortest(walk.back(), viewpoints.front());
      walk.insert(walk.end(), between.begin() + 1, between.end());
      walk.insert(walk.end(), viewpoints.begin() + 1, viewpoints.end());
      joined.path.instructions = products(joined.path.instructions, next.instructions);
      joined.from.push_back(next.path_id);
    }
    joined.path.distance = distance;
    joined.path.path = names(walk);
    joined.shortest = names(shortest(walk.front(), walk.back()));
    joined.shortest_distance = graph_.distance(walk.front(), walk.back());
    return joined;
  }

 private:
  // Those of one path more.
  std::vector<std::size_t> extended(const std::vector<std::size_t>& sequences, std::size_t length,
                                    const std::vector<std::size_t>& members) const {
    std::vector<std::size_t> longer;
    for (std::size_t begin = 0; begin < sequences.size(); begin += length) {
      const auto first = sequences.begin() + static_cast<std::ptrdiff_t>(begin);
      const auto last = first + static_cast<std::ptrdiff_t>(length);
      const ViewpointIndex end = paths_[*std::prev(last)].viewpoints.back();
      for (const std::size_t next : members) {
        const double gap = graph_.distance(end, paths_[next].viewpoints.front());
        if (gap > options_.most_gap) continue;
        longer.insert(longer.end(), first, last);
        longer.push_back(next);
      }
    }
    return longer;
  }

  static std::vector<std::string> products(const std::vector<std::string>& before,
                                           const std::vector<std::string>& after) {
    std::vector<std::string> texts;
    texts.reserve(before.size() * after.size());
    for (const std::string& x : before) {
      for (const std::string& y : after) texts.push_back(x + y);
    }
    return texts;
  }

  std::vector<ViewpointIndex> shortest(ViewpointIndex a, ViewpointIndex b) const {
    // Only paths of which two viewpoints in turn need not be adjacent can end out of reach.
    if (auto path = graph_.path(a, b)) return *std::move(path);
    throw ArgumentError(
        fmt::format("scan {}: a path joined there would end at {}, out of reach from its start {}",
                    graph_.scan(), graph_.id(b), graph_.id(a)));
  }
  std::vector<std::string> names(const std::vector<ViewpointIndex>& viewpoints) const {
    std::vector<std::string> ids;
    ids.reserve(viewpoints.size());
    for (const ViewpointIndex v : viewpoints) ids.push_back(graph_.id(v));
    return ids;
  }

  const std::vector<PathAnnotation>& entries_;
  const std::vector<ReferencePath>& paths_;
  const graph::NavGraph& graph_;
  const JoinOptions& options_;
};

// All sequences of paths that are joined, by number.
class Plan {
 public:
  Plan(const Annotations& annotations, const graph::GraphSet& graphs, const JoinOptions& options)
      : entries_(annotations.paths), graphs_(graphs), options_(options) {
    check_options(options);
    paths_ = look_up_paths(annotations, graphs);
    check_paths(entries_);
    groups_ = by_scan(paths_, graphs.size());
    sequences_.resize(groups_.size());
    std::vector<std::size_t> looked_at(groups_.size());
    parallel_for(groups_.size(), 1, options.threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        sequences_[i] = joiner(i).sequences(groups_[i].members, looked_at[i]);
      }
    });
    for (std::size_t i = 0; i < groups_.size(); ++i) {
      pairs_ += looked_at[i];
      begins_.push_back(size_);
      size_ += sequences_[i].size() / options.paths;
    }
  }

  std::size_t size() const noexcept { return size_; }
  std::size_t pairs() const noexcept { return pairs_; }

  // Path `number` of all. \pre number < size()
  JoinedPath path(std::size_t number) const {
    const auto after = std::ranges::upper_bound(begins_, number);
    const auto group = static_cast<std::size_t>(after - begins_.begin()) - 1;
    const std::span<const std::size_t> all = sequences_[group];
    JoinedPath joined = joiner(group).path_of(
        all.subspan((number - begins_[group]) * options_.paths, options_.paths));
    joined.path.path_id = static_cast<std::int64_t>(number);
    return joined;
  }

 private:
  Joiner joiner(std::size_t group) const {
    return {entries_, paths_, graphs_.graph(groups_[group].scan), options_};
  }

  const std::vector<PathAnnotation>& entries_;
  const graph::GraphSet& graphs_;
  JoinOptions options_;
  std::vector<ReferencePath> paths_;
  std::vector<PathsOfScan> groups_;
  std::vector<std::vector<std::size_t>> sequences_;  // by group
  std::vector<std::size_t> begins_;                  // the number of each group's first
  std::size_t size_ = 0, pairs_ = 0;
};

// Appends JSON to a text. A set of joined paths has some hundred megabytes, so that no tree of
// values is built.
class JsonText {
 public:
  JsonText& raw(std::string_view json) {
    text_ += json;
    return *this;
  }
  JsonText& integer(std::int64_t value) {
    fmt::format_to(std::back_inserter(text_), "{}", value);
    return *this;
  }
  // As Python writes it: of the texts that are read back equal the shortest, with a point.
  JsonText& number(double value) {
    valid_ = valid_ && std::isfinite(value);
    const std::size_t begin = text_.size();
    fmt::format_to(std::back_inserter(text_), "{}", value);
    if (text_.find_first_of(".e", begin) == text_.npos) text_ += ".0";
    return *this;
  }
  JsonText& string(std::string_view value) {
    text_ += '"';
    std::size_t copied = 0;
    for (std::size_t at = 0; at < value.size();) {
      const auto c = static_cast<unsigned char>(value[at]);
      if (c >= 0x20 && c < 0x80 && c != '"' && c != '\\') {
        ++at;
        continue;
      }
      text_ += value.substr(copied, at - copied);
      at += special(value.substr(at));
      copied = at;
    }
    text_ += value.substr(copied);
    text_ += '"';
    return *this;
  }
  JsonText& strings(const std::vector<std::string>& values) {
    text_ += '[';
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (k > 0) text_ += ',';
      string(values[k]);
    }
    text_ += ']';
    return *this;
  }

  bool valid() const { return valid_; }
  std::string take() { return std::move(text_); }

 private:
  // What cannot stand as it is, or has to be looked at. Gives its bytes.
  std::size_t special(std::string_view rest) {
    const auto c = static_cast<unsigned char>(rest[0]);
    if (c >= 0x80) {
      const std::size_t length = utf8_length(rest);
      valid_ = valid_ && length > 0;
      text_ += rest.substr(0, length);
      return std::max<std::size_t>(length, 1);
    }
    constexpr std::string_view kEscaped = "\"\\\b\f\n\r\t", kLetters = "\"\\bfnrt";
    if (const std::size_t k = kEscaped.find(rest[0]); k != kEscaped.npos) {
      text_ += '\\';
      text_ += kLetters[k];
    } else {
      fmt::format_to(std::back_inserter(text_), "\\u{:04x}", c);
    }
    return 1;
  }

  std::string text_;
  bool valid_ = true;
};

void write_origin(const std::vector<std::int64_t>& from, JsonText& text) {
  if (from.size() == 2) {
    text.raw(R"("first_path_id":)").integer(from[0]);
    text.raw(R"(,"second_path_id":)").integer(from[1]);
    return;
  }
  text.raw(R"("path_ids":[)");
  for (std::size_t k = 0; k < from.size(); ++k) text.raw(k > 0 ? "," : "").integer(from[k]);
  text.raw("]");
}

void write_path(const JoinedPath& joined, JsonText& text) {
  const PathAnnotation& path = joined.path;
  text.raw("{");
  if (path.distance) text.raw(R"("distance":)").number(*path.distance).raw(",");
  write_origin(joined.from, text);
  text.raw(R"(,"heading":)").number(path.heading.value);
  text.raw(R"(,"instructions":)").strings(path.instructions);
  text.raw(R"(,"path":)").strings(path.path);
  text.raw(R"(,"path_id":)").integer(path.path_id);
  text.raw(R"(,"scan":)").string(path.scan);
  text.raw(R"(,"shortest_path":)").strings(joined.shortest);
  text.raw(R"(,"shortest_path_distance":)").number(joined.shortest_distance);
  text.raw("}");
}

// \param first  whether it is the first of all
void write_entry(const JoinedPath& joined, bool first, JsonText& text) {
  text.raw(first ? "\n" : ",\n");
  write_path(joined, text);
  if (text.valid()) return;
  throw ArgumentError(fmt::format("path {}: holds text that is not UTF-8, or an infinite number",
                                  joined.path.path_id));
}

// The text of some paths, and what they add up to.
struct Piece {
  std::string text;
  JoinTotals totals;
};

Piece piece_of(const Plan& plan, std::size_t begin, std::size_t end) {
  Piece piece;
  JsonText text;
  for (std::size_t number = begin; number < end; ++number) {
    const JoinedPath joined = plan.path(number);
    write_entry(joined, number == 0, text);
    ++piece.totals.paths;
    piece.totals.instructions += joined.path.instructions.size();
    piece.totals.length += joined.path.distance.value_or(0);
  }
  piece.text = text.take();
  return piece;
}

}  // namespace

Joined join_paths(const Annotations& annotations, const graph::GraphSet& graphs,
                  const JoinOptions& options) {
  const Plan plan(annotations, graphs, options);
  Joined joined;
  joined.pairs = plan.pairs();
  joined.paths.resize(plan.size());
  constexpr std::size_t kGrain = 256;
  parallel_for(plan.size(), kGrain, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) joined.paths[i] = plan.path(i);
  });
  return joined;
}

JoinTotals write_joined(const Annotations& annotations, const graph::GraphSet& graphs,
                        const JoinOptions& options, const TakeText& take) {
  // Of R8R a path has 81 instructions, together some 40 kB: 80 MB at a time.
  constexpr std::size_t kOfPiece = 64, kPieces = 32;
  const Plan plan(annotations, graphs, options);
  JoinTotals totals;
  totals.pairs = plan.pairs();
  take("[");
  std::vector<Piece> pieces;
  for (std::size_t first = 0; first < plan.size(); first += kOfPiece * kPieces) {
    const std::size_t left = plan.size() - first;
    pieces.assign(std::min(kPieces, (left + kOfPiece - 1) / kOfPiece), Piece());
    parallel_for(pieces.size(), 1, options.threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        const std::size_t at = first + k * kOfPiece;
        pieces[k] = piece_of(plan, at, std::min(at + kOfPiece, plan.size()));
      }
    });
    for (const Piece& piece : pieces) {
      take(piece.text);
      totals.paths += piece.totals.paths;
      totals.instructions += piece.totals.instructions;
      totals.length += piece.totals.length;
    }
  }
  take("\n]\n");
  return totals;
}

std::string to_json(const Joined& joined) {
  JsonText text;
  text.raw("[");
  for (const JoinedPath& path : joined.paths) {
    write_entry(path, &path == joined.paths.data(), text);
  }
  text.raw("\n]\n");
  return text.take();
}

}  // namespace enfilade::tasks
