#include "enfilade/tasks/annotations.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <utility>

#include "enfilade/core/detail/json.h"
#include "enfilade/core/gzip.h"
#include "enfilade/tasks/formats/r2r_entries.h"

namespace enfilade::tasks {

Annotations load_annotations(const std::filesystem::path& file, std::string split) {
  return parse_annotations(read_text_file(file), file.string(), std::move(split));
}

Annotations parse_annotations(std::string_view json, const std::string& file, std::string split) {
  const json::Document document = json::Document::parse(json, file);
  Annotations result{std::move(split), file, {}};
  json::Faults faults(file);
  const json::Path root;
  if (const auto entries = json::array(document.root(), root, faults)) {
    formats::PathIds ids;  // which name results
    for (const json::Element element : *entries) {
      const std::size_t i = result.paths.size();
      const json::Path path(root, i);
      const std::size_t errors = faults.errors();
      result.paths.push_back(formats::read_r2r_entry(element, i, path, faults));
      if (faults.errors() == errors) ids.check(result.paths.back(), i, path, faults);
    }
  }
  faults.throw_if_errors();
  return result;
}

std::string to_json(const Annotations& annotations) {
  return formats::list_of_entries(annotations, formats::r2r_fields);
}

std::string instruction_id(std::int64_t path_id, std::size_t k) {
  return fmt::format("{}_{}", path_id, k);
}

}  // namespace enfilade::tasks
