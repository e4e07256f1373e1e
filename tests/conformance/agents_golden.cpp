#include "tests/conformance/agents_golden.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "enfilade/core/errors.h"
#include "enfilade/core/gzip.h"

namespace enfilade::tests {
namespace {

constexpr std::size_t kExamples = 5;  // of a file

nlohmann::json parse(std::string_view text, const std::string& file, const std::string& where) {
  auto value = nlohmann::json::parse(text, nullptr, false);
  if (value.is_discarded()) refuse(file, where, "not-json", "not JSON");
  return value;
}

template <class T>
std::vector<double> numbers_of(std::span<const std::byte> bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
  return {values.begin(), values.end()};
}

}  // namespace

bool AgentsFolder::has(const std::string& name) const {
  return std::filesystem::is_regular_file(file(name));
}

nlohmann::json AgentsFolder::json(const std::string& name) const {
  return parse(read_text_file(file(name)), file(name).string(), "");
}

std::vector<nlohmann::json> AgentsFolder::json_lines(const std::string& name) const {
  const std::string text = read_text_file(file(name));
  std::vector<nlohmann::json> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    if (end > at) {
      lines.push_back(parse(std::string_view(text).substr(at, end - at), file(name).string(),
                            fmt::format("line {}", lines.size() + 1)));
    }
    at = end + 1;
  }
  return lines;
}

features::TensorFile AgentsFolder::tensors(const std::string& name) const {
  return features::TensorFile::open(file(name));
}

std::vector<std::string> AgentsFolder::names() const {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(path_)) {
    if (entry.is_regular_file()) names.push_back(entry.path().filename().string());
  }
  std::ranges::sort(names);
  return names;
}

void AgentsTally::begin(const std::string& file) {
  const auto known = std::ranges::find(files_, file, &File::name);
  if (known != files_.end()) {  // goes on with it: it becomes the last again
    std::rotate(known, known + 1, files_.end());
    return;
  }
  files_.emplace_back();
  files_.back().name = file;
}

void AgentsTally::wrong(std::string line) {
  File& file = files_.back();
  ++file.mismatches;
  if (file.examples.size() < kExamples) file.examples.push_back(std::move(line));
}

void AgentsTally::equal(std::string_view name, const nlohmann::json& recorded,
                        const nlohmann::json& ours) {
  ++files_.back().values;
  if (recorded == ours) return;
  constexpr std::size_t kLongest = 200;
  wrong(fmt::format("{}: recorded {}, ours {}", name, recorded.dump().substr(0, kLongest),
                    ours.dump().substr(0, kLongest)));
}

void AgentsTally::near(std::string_view name, double recorded, double ours, double tolerance) {
  ++files_.back().values;
  if (recorded == ours) return;
  const double allowed = tolerance * std::max(1.0, std::abs(recorded));
  // False for NaN; of infinities only equal ones agree.
  if (std::isfinite(recorded) && std::abs(recorded - ours) <= allowed) return;
  wrong(fmt::format("{}: recorded {}, ours {}", name, recorded, ours));
}

void AgentsTally::near_all(std::string_view name, std::span<const double> recorded,
                           std::span<const double> ours, double tolerance) {
  if (recorded.size() != ours.size()) {
    ++files_.back().values;
    wrong(fmt::format("{}: {} numbers, ours are {}", name, recorded.size(), ours.size()));
    return;
  }
  for (std::size_t i = 0; i < recorded.size(); ++i) {
    near(fmt::format("{}[{}]", name, i), recorded[i], ours[i], tolerance);
  }
}

void AgentsTally::near_json(std::string_view name, const nlohmann::json& recorded,
                            std::span<const double> ours, double tolerance) {
  std::vector<double> numbers;
  for (const auto& value : recorded) numbers.push_back(golden_number(value));
  near_all(name, numbers, ours, tolerance);
}

double golden_number(const nlohmann::json& value) {
  if (value.is_null()) return -std::numeric_limits<double>::infinity();
  if (!value.is_number()) throw Error("a recording has " + value.dump() + " in place of a number");
  return value.get<double>();
}

std::vector<double> golden_array(const features::TensorFile& file, const std::string& name) {
  const features::NamedArray* array = file.find(name);
  if (array == nullptr) {
    throw Error(fmt::format("{}: has no array {:?}", file.path().string(), name));
  }
  switch (array->type) {
    case features::DType::kFloat32:
      return numbers_of<float>(array->bytes);
    case features::DType::kFloat64:
      return numbers_of<double>(array->bytes);
    case features::DType::kInt32:
      return numbers_of<std::int32_t>(array->bytes);
    case features::DType::kInt64:
      return numbers_of<std::int64_t>(array->bytes);
    case features::DType::kUint8:
    case features::DType::kBool:
      return numbers_of<std::uint8_t>(array->bytes);
    default:
      throw Error(fmt::format("{}: array {:?} is of type {}", file.path().string(), name,
                              enum_name(array->type)));
  }
}

}  // namespace enfilade::tests
