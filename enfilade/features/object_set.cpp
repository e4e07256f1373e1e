#include "enfilade/features/object_set.h"

#include <fmt/format.h>
#include <algorithm>
#include <cstring>
#include <functional>
#include <map>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/features/formats/object_hdf5.h"

namespace enfilade::features {

struct ObjectSet::Impl {
  explicit Impl(const std::filesystem::path& path)
      : file(path), read(formats::read_object_hdf5(path)) {
    for (const formats::ViewpointObjects& viewpoint : read.viewpoints) {
      by_name.emplace(viewpoint.name, &viewpoint);
      most = std::max(most, viewpoint.objects.size());
    }
  }

  const formats::ViewpointObjects* find(std::string_view scan, std::string_view viewpoint) const {
    const auto found = by_name.find(fmt::format("{}_{}", scan, viewpoint));
    return found == by_name.end() ? nullptr : found->second;
  }

  std::filesystem::path file;
  formats::ObjectRows read;
  std::map<std::string, const formats::ViewpointObjects*, std::less<>> by_name;
  std::size_t most = 0;
};

ObjectSet ObjectSet::open(const std::filesystem::path& file) {
  ObjectSet set;
  set.impl_ = std::make_shared<const Impl>(file);
  return set;
}

std::size_t ObjectSet::dimensions() const noexcept { return impl_->read.dimensions; }
std::size_t ObjectSet::viewpoints() const noexcept { return impl_->read.viewpoints.size(); }
std::size_t ObjectSet::most_objects() const noexcept { return impl_->most; }
const std::filesystem::path& ObjectSet::file() const noexcept { return impl_->file; }

std::span<const ObjectView> ObjectSet::objects(std::string_view scan,
                                               std::string_view viewpoint) const {
  const auto* const found = impl_->find(scan, viewpoint);
  return found == nullptr ? std::span<const ObjectView>() : std::span(found->objects);
}

void ObjectSet::copy(std::string_view scan, std::string_view viewpoint, std::size_t i,
                     std::span<float> out) const {
  const auto* const found = impl_->find(scan, viewpoint);
  EN_CHECK(found != nullptr);
  EN_CHECK_LT(i, found->objects.size());
  EN_CHECK_LE(out.size(), dimensions());
  const auto row = found->numbers.subspan(i * dimensions() * sizeof(float), out.size_bytes());
  std::memcpy(out.data(), row.data(), row.size());
}

}  // namespace enfilade::features
