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

/// \param code of a text that check() does not allow
std::string read_text(json::Element element, const json::Path& path, TextCheck check,
                      std::string_view allowed, json::Faults& faults, const char* code) {
  const auto text = json::string(element, path, faults);
  if (text && !check(*text)) {
    faults.error(path, code, fmt::format("{:?}, not {}", text->substr(0, kQuoted), allowed));
  }
  return std::string(text.value_or(""));
}

}  // namespace

void read_body(std::string_view body, const char* file, const json::Limits& limits,
               Fields::Names required, Fields::Names optional,
               const std::function<void(const Fields&, json::Faults&)>& read, Others others) {
  const std::string excess = json::excess(body, limits);
  if (!excess.empty()) refuse(file, "$", "too-large", excess);
  const json::Document document = json::Document::parse(body, file);
  json::Faults faults(file);
  const json::Path root;
  const Fields fields(document.root(), root, faults, required, optional);
  const bool known = others == Others::kIgnored || fields.refuse_others();
  if (known && fields.complete()) read(fields, faults);
  faults.throw_if_errors();
}

Fields::Fields(json::Element element, const json::Path& path, json::Faults& faults, Names required,
               Names optional)
    : element_(element), path_(path), faults_(faults) {
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

std::string Fields::string(std::string_view name) const {
  return std::string(json::string((*this)[name], path(name), faults_).value_or(""));
}

bool Fields::boolean(std::string_view name) const {
  return has(name) && json::boolean((*this)[name], path(name), faults_).value_or(false);
}

void Fields::list(std::string_view name, std::size_t most, std::string_view things,
                  const std::function<void(json::Element, const json::Path&)>& read) const {
  const json::Path here = path(name);
  const auto elements = json::array((*this)[name], here, faults_);
  if (!elements) return;
  std::size_t k = 0;
  for (const json::Element one : *elements) {
    if (faults_.full()) return;
    if (k == most) {
      faults_.error(here, "too-many", fmt::format("more than {}{}", most, things));
      return;
    }
    read(one, json::Path(here, k++));
  }
}

std::vector<std::string> Fields::texts(std::string_view name, std::size_t most, TextCheck check,
                                       std::string_view allowed) const {
  std::vector<std::string> found;
  list(name, most, "", [&](json::Element one, const json::Path& here) {
    found.push_back(read_text(one, here, check, allowed, faults_, "bad-text"));
  });
  return found;
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
