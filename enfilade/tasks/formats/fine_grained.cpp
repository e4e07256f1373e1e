#include "enfilade/tasks/formats/fine_grained.h"

#include <fmt/format.h>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "enfilade/tasks/formats/python_literal.h"
#include "enfilade/tasks/formats/r2r_entries.h"
#include "enfilade/tasks/formats/records.h"

namespace enfilade::tasks::formats {
namespace {

using Parts = std::vector<std::vector<SubInstruction>>;  // by instruction

enum FineField : std::size_t { kNewInstructions, kChunkView, kFineEncodings, kFineFields };
constexpr std::array<json::Field, kFineFields> kOfFine{
    {{"new_instructions"}, {"chunk_view", false}, {"instr_encodings", false}}};

// Nothing if the literal cannot be read.
std::optional<Parts> read_literal(json::Element element, const json::Path& path,
                                  json::Faults& faults) {
  const auto text = json::string(element, path, faults);
  if (!text) return std::nullopt;
  WordLists lists;
  if (const auto fault = read_word_lists(*text, lists)) {
    faults.error(path, "bad-literal", fmt::format("byte {}: {}", fault->byte, fault->message));
    return std::nullopt;
  }
  Parts parts(lists.size());
  for (std::size_t k = 0; k < lists.size(); ++k) {
    for (auto& words : lists[k]) parts[k].push_back({std::move(words), std::nullopt});
  }
  return parts;
}

// A list with as many elements as there are `things`.
std::optional<simdjson::dom::array> list_of(std::size_t count, const char* things,
                                            json::Element element, const json::Path& path,
                                            json::Faults& faults) {
  auto list = json::array(element, path, faults);
  if (!list || list->size() == count) return list;
  faults.error(path, "wrong-count",
               fmt::format("array of {}; {} are expected, one for each {} of new_instructions",
                           list->size(), count, things));
  return std::nullopt;
}

// [first, last], 1-based. \param viewpoints  of the path
void read_chunk(json::Element element, std::size_t viewpoints, SubInstruction& part,
                const json::Path& path, json::Faults& faults) {
  const auto list = json::array(element, path, faults);
  if (!list) return;
  if (list->size() != 2) {
    faults.error(path, "bad-chunk", fmt::format("array of {}, not [first, last]", list->size()));
    return;
  }
  const auto first = json::integer(list->at(0).value_unsafe(), json::Path(path, 0), faults);
  const auto last = json::integer(list->at(1).value_unsafe(), json::Path(path, 1), faults);
  if (!first || !last) return;
  if (*first < 1 || *last < *first || std::cmp_greater(*last, viewpoints)) {
    faults.error(path, "bad-chunk",
                 fmt::format("[{}, {}] are no places on a path of {}; 1 to {} are, the first not "
                             "after the last",
                             *first, *last, viewpoints, viewpoints));
    return;
  }
  part.places.emplace(static_cast<std::size_t>(*first - 1), static_cast<std::size_t>(*last - 1));
}

void read_chunks(json::Element element, std::size_t viewpoints, Parts& parts,
                 const json::Path& path, json::Faults& faults) {
  const auto lists = list_of(parts.size(), "instruction", element, path, faults);
  if (!lists) return;
  std::size_t k = 0;
  for (const json::Element list : *lists) {
    if (faults.full()) return;
    const json::Path place(path, k);
    std::vector<SubInstruction>& pieces = parts[k++];
    const auto chunks = list_of(pieces.size(), "piece", list, place, faults);
    if (!chunks) continue;
    std::size_t i = 0;
    for (const json::Element chunk : *chunks) {
      read_chunk(chunk, viewpoints, pieces[i], json::Path(place, i), faults);
      ++i;
    }
  }
}

// What stands beside the fields of R2R.
// \param complete  whether those could be read, so that the others can be compared with them
void read_fine_fields(json::Element element, bool complete, PathAnnotation& entry,
                      const json::Path& path, json::Faults& faults) {
  std::array<std::optional<json::Element>, kFineFields> found;
  if (!json::fields(element, kOfFine, found, path, faults)) return;
  if (found[kFineEncodings]) {
    read_encodings(*found[kFineEncodings], complete, entry, json::Path(path, "instr_encodings"),
                   faults);
  }
  const json::Path literal(path, "new_instructions");
  auto parts = read_literal(*found[kNewInstructions], literal, faults);
  if (!parts || !complete) return;
  if (found[kChunkView]) {
    read_chunks(*found[kChunkView], entry.path.size(), *parts, json::Path(path, "chunk_view"),
                faults);
  }
  if (parts->size() > entry.instructions.size()) {
    faults.error(literal, "wrong-count",
                 fmt::format("lists of {} instructions; the path has {}", parts->size(),
                             entry.instructions.size()));
    return;
  }
  entry.details.resize(entry.instructions.size());
  for (std::size_t k = 0; k < parts->size(); ++k) entry.details[k].parts = std::move((*parts)[k]);
}

}  // namespace

Annotations parse_fine_grained(std::string_view json, const std::string& file, std::string split) {
  PathIds ids;
  return read_records(
      json, file, std::move(split), Task::kR2r,
      [&](json::Element element, std::size_t record, const json::Path& path, json::Faults& faults) {
        return read_entry(element, record, read_fine_fields, ids, path, faults);
      });
}

}  // namespace enfilade::tasks::formats
