#include "enfilade/tasks/formats/readers.h"

#include <fmt/format.h>
#include <optional>
#include <utility>
#include <vector>

#include "enfilade/tasks/formats/python_literal.h"
#include "enfilade/tasks/formats/records.h"

namespace enfilade::tasks::formats {
namespace {

using Parts = std::vector<std::vector<SubInstruction>>;  // by instruction

// Nothing if the literal cannot be read.
std::optional<Parts> read_literal(Element element, const Path& path, Faults& faults) {
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
std::optional<simdjson::dom::array> list_of(std::size_t count, const char* things, Element element,
                                            const Path& path, Faults& faults) {
  auto list = json::array(element, path, faults);
  if (!list || list->size() == count) return list;
  faults.error(path, "wrong-count",
               fmt::format("array of {}; {} are expected, one for each {} of new_instructions",
                           list->size(), count, things));
  return std::nullopt;
}

// [first, last], 1-based. \param viewpoints  of the path
void read_chunk(Element element, std::size_t viewpoints, SubInstruction& part, const Path& path,
                Faults& faults) {
  const auto list = json::array(element, path, faults);
  if (!list) return;
  if (list->size() != 2) {
    faults.error(path, "bad-chunk", fmt::format("array of {}, not [first, last]", list->size()));
    return;
  }
  const auto first = json::integer(list->at(0).value_unsafe(), Path(path, 0), faults);
  const auto last = json::integer(list->at(1).value_unsafe(), Path(path, 1), faults);
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

void read_chunks(Element element, std::size_t viewpoints, Parts& parts, const Path& path,
                 Faults& faults) {
  const auto lists = list_of(parts.size(), "instruction", element, path, faults);
  if (!lists) return;
  std::size_t k = 0;
  for (const Element list : *lists) {
    if (faults.full()) return;
    const Path place(path, k);
    std::vector<SubInstruction>& pieces = parts[k++];
    const auto chunks = list_of(pieces.size(), "piece", list, place, faults);
    if (!chunks) continue;
    std::size_t i = 0;
    for (const Element chunk : *chunks) {
      read_chunk(chunk, viewpoints, pieces[i], Path(place, i), faults);
      ++i;
    }
  }
}

// What stands beside the fields of R2R.
// \param complete  whether those could be read, so that the others can be compared with them
void read_fine_fields(Element element, bool complete, PathAnnotation& entry, const Path& path,
                      Faults& faults) {
  const Fields found(element, {"new_instructions"}, {"chunk_view", "instr_encodings"}, path,
                     faults);
  if (!found) return;
  if (const auto& encodings = found["instr_encodings"]) {
    read_encodings(*encodings, complete, entry, found.place("instr_encodings"), faults);
  }
  auto parts = found.get("new_instructions", read_literal);
  if (!parts || !complete) return;
  if (const auto& chunks = found["chunk_view"]) {
    read_chunks(*chunks, entry.path.size(), *parts, found.place("chunk_view"), faults);
  }
  if (parts->size() > entry.instructions.size()) {
    faults.error(found.place("new_instructions"), "wrong-count",
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
  return read_records(json, file, std::move(split), Task::kR2r,
                      [&](Element element, std::size_t record, const Path& path, Faults& faults) {
                        return read_entry(element, record, read_fine_fields, ids, path, faults);
                      });
}

}  // namespace enfilade::tasks::formats
