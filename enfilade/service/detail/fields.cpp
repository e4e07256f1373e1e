#include "enfilade/service/detail/fields.h"

#include <fmt/format.h>
#include <algorithm>

#include "enfilade/core/check.h"

namespace enfilade::service::detail {
namespace {

template <class T>
T within(std::optional<T> value, T least, T most, const json::Path& path, json::Faults& faults) {
  if (value && !(*value >= least && *value <= most)) {
    faults.error(path, "out-of-range", fmt::format("{}, not from {} to {}", *value, least, most));
  }
  return value.value_or(least);
}

}  // namespace

std::string read_text(json::Element element, const json::Path& path, TextCheck check,
                      std::string_view allowed, json::Faults& faults, const char* code) {
  const auto text = json::string(element, path, faults);
  if (text && !check(*text)) {
    faults.error(path, code, fmt::format("{:?}, not {}", text->substr(0, kQuoted), allowed));
  }
  return std::string(text.value_or(""));
}

Fields::Fields(json::Element element, const json::Path& path, json::Faults& faults, Names required,
               Names optional)
    : path_(path), faults_(faults) {
  for (const std::string_view name : required) wanted_.push_back({name});
  for (const std::string_view name : optional) wanted_.push_back({name, false});
  found_.resize(wanted_.size());
  complete_ = json::fields(element, wanted_, found_, path_, faults_);
}

const std::optional<json::Element>& Fields::find(std::string_view name) const {
  const auto field = std::ranges::find(wanted_, name, &json::Field::name);
  EN_CHECK(field != wanted_.end());
  return found_[static_cast<std::size_t>(field - wanted_.begin())];
}

bool Fields::has(std::string_view name) const { return find(name).has_value(); }

json::Element Fields::operator[](std::string_view name) const { return find(name).value(); }

std::string Fields::text(std::string_view name, TextCheck check, std::string_view allowed,
                         const char* code) const {
  return read_text((*this)[name], path(name), check, allowed, faults_, code);
}

int Fields::integer(std::string_view name, int least, int most, int otherwise) const {
  if (!has(name)) return otherwise;
  const auto value = json::integer((*this)[name], path(name), faults_);
  return static_cast<int>(std::clamp<std::int64_t>(
      within<std::int64_t>(value, least, most, path(name), faults_), least, most));
}

double Fields::number(std::string_view name, double least, double most) const {
  return within(json::number((*this)[name], path(name), faults_), least, most, path(name), faults_);
}

}  // namespace enfilade::service::detail
