#include "enfilade/features/feature_set.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"
#include "enfilade/features/formats/feature_rows.h"

namespace enfilade::features {
namespace {

namespace fs = std::filesystem;

struct Format {
  std::string_view suffix;
  FeatureFormat format;
  formats::FeatureRows (*read)(const fs::path&);
  std::unique_ptr<formats::RowWriter> (*write)(const fs::path&, const FeatureInfo&,
                                               const std::vector<FeatureKey>&);
};
constexpr std::array kFormats{
    Format{".safetensors", FeatureFormat::kSafetensors, formats::read_feature_safetensors,
           formats::write_feature_safetensors},
    Format{".tsv", FeatureFormat::kTsv, formats::read_feature_tsv, formats::write_feature_tsv},
    Format{".h5", FeatureFormat::kHdf5, formats::read_feature_hdf5, formats::write_feature_hdf5},
    Format{".hdf5", FeatureFormat::kHdf5, formats::read_feature_hdf5, formats::write_feature_hdf5},
};

const Format& find_format(const fs::path& file) {
  const auto found = std::ranges::find(kFormats, file.extension().string(), &Format::suffix);
  if (found != kFormats.end()) return *found;
  throw ArgumentError(
      fmt::format("{}: ends neither in .safetensors nor in .tsv, .h5 or .hdf5", file.string()));
}

std::string place_of(const FeatureKey& key) {
  return fmt::format("scan {}, viewpoint {}", quote(key.scan), quote(key.viewpoint));
}

void check_info(const fs::path& file, const FeatureInfo& info) {
  if (info.views == 0 || info.dimensions == 0) {
    throw ArgumentError(fmt::format("{}: {} views of {} dimensions, not 1 or more of each",
                                    file.string(), info.views, info.dimensions));
  }
  if (info.type != DType::kFloat32 && info.type != DType::kFloat16) {
    throw ArgumentError(
        fmt::format("{}: numbers of type {}, not F32 or F16", file.string(), enum_name(info.type)));
  }
  validate(info.camera);
}

// Each viewpoint needs a name of its own, which is read back.
void check_keys(const fs::path& file, const std::vector<FeatureKey>& keys) {
  if (keys.empty()) throw ArgumentError(file.string() + ": features of no viewpoint");
  std::unordered_map<std::string, std::size_t> names;
  for (const FeatureKey& key : keys) {
    const std::string name = formats::name_of(key);
    for (const std::string& id : {key.scan, key.viewpoint}) {
      const std::string fault = fault_of_id(id);
      if (!fault.empty())
        throw ArgumentError(fmt::format("{}: {}: {}", file.string(), place_of(key), fault));
    }
    if (!names.emplace(name, names.size()).second) {
      throw ArgumentError(fmt::format("{}: {} comes twice", file.string(), place_of(key)));
    }
  }
}

}  // namespace

FeatureFormat format_of(const fs::path& file) { return find_format(file).format; }

// --- FeatureSet -----------------------------------------------------------------------------

struct FeatureSet::Impl {
  explicit Impl(const fs::path& path)
      : file(path.string()), read(find_format(path).read(path)), info(read.info) {
    rows.reserve(read.keys.size());
    for (std::size_t i = 0; i < read.keys.size(); ++i) {
      if (!rows.emplace(formats::name_of(read.keys[i]), i).second) {
        refuse(file, place_of(read.keys[i]), "repeated-viewpoint", "comes twice, not once");
      }
    }
  }

  void copy(std::size_t row, std::size_t view, std::span<float> out) const {
    const std::byte* const from =
        read.rows[row] + view * read.info.dimensions * size_of(read.info.type);
    if (!formats::copy_numbers(from, read.info.type, out)) {
      refuse(file, place_of(read.keys[row]), "not-finite", "a number that is infinite or NaN");
    }
  }

  std::string file;
  formats::FeatureRows read;
  FeatureInfo info;  ///< with the columns that are shown, perhaps fewer than were read
  std::unordered_map<std::string, std::size_t> rows;  ///< by name: either id may have a "_"
};

FeatureSet FeatureSet::open(const fs::path& file) {
  FeatureSet set;
  set.impl_ = std::make_shared<const Impl>(file);
  return set;
}

const FeatureInfo& FeatureSet::info() const noexcept { return impl_->info; }

std::span<const FeatureKey> FeatureSet::keys() const noexcept { return impl_->read.keys; }

std::optional<std::size_t> FeatureSet::row(std::string_view scan,
                                           std::string_view viewpoint) const {
  const auto found =
      impl_->rows.find(formats::name_of({std::string(scan), std::string(viewpoint)}));
  if (found == impl_->rows.end()) return std::nullopt;
  return found->second;
}

void FeatureSet::copy_view(std::size_t row, std::size_t view, std::span<float> out) const {
  EN_CHECK_LT(row, keys().size());
  EN_CHECK_LT(view, info().views);
  EN_CHECK_EQ(out.size(), info().dimensions);
  impl_->copy(row, view, out);
}

void FeatureSet::copy_views(std::size_t row, std::span<float> out) const {
  EN_CHECK_LT(row, keys().size());
  EN_CHECK_EQ(out.size(), formats::row_elements(info()));
  const std::size_t n = info().dimensions;
  if (n == impl_->read.info.dimensions) return impl_->copy(row, 0, out);
  for (std::size_t view = 0; view < info().views; ++view) {
    impl_->copy(row, view, out.subspan(view * n, n));
  }
}

FeatureSet FeatureSet::first_columns(std::size_t n) const {
  if (n == 0 || n > info().dimensions) {
    throw ArgumentError(
        fmt::format("columns: {}, not from 1 to the {} that there are", n, info().dimensions));
  }
  auto fewer = std::make_shared<Impl>(*impl_);
  fewer->info.dimensions = n;
  FeatureSet set;
  set.impl_ = std::move(fewer);
  return set;
}

FeatureSet without_class_scores(const FeatureSet& features, std::size_t dimensions) {
  constexpr std::size_t kClasses = 1000;
  const bool has_scores = dimensions > 0 && features.info().dimensions == dimensions + kClasses;
  return has_scores ? features.first_columns(dimensions) : features;
}

// --- FeatureWriter --------------------------------------------------------------------------

struct FeatureWriter::Impl {
  Impl(const fs::path& path, const FeatureInfo& what, std::vector<FeatureKey> of)
      : file(path.string()), info(what), keys(std::move(of)), done(keys.size()) {
    check_info(path, info);
    check_keys(path, keys);
    rows = find_format(path).write(path, info, keys);
    for (std::size_t i = 0; i < keys.size(); ++i) done[i] = rows->written(i);
    left = static_cast<std::size_t>(std::ranges::count(done, false));
  }

  void check_numbers(std::size_t row, std::span<const float> views) const {
    if (views.size() != formats::row_elements(info)) {
      throw ArgumentError(fmt::format("{}: {}: {} numbers, not {} x {}", file, place_of(keys[row]),
                                      views.size(), info.views, info.dimensions));
    }
    const float largest = info.type == DType::kFloat16 ? 65504.0F : 3.402823466e38F;
    // Halves are rounded to the nearest: values up to half a step above the largest become it.
    const float limit = info.type == DType::kFloat16 ? 65520.0F : INFINITY;
    const auto unfit = [limit](float value) { return !(std::abs(value) < limit); };
    const auto wrong = std::ranges::find_if(views, unfit);
    if (wrong != views.end()) {
      throw ArgumentError(fmt::format("{}: {}: number {} is {}, not from -{} to {}", file,
                                      place_of(keys[row]), wrong - views.begin(), *wrong, largest,
                                      largest));
    }
  }

  std::string file;
  FeatureInfo info;
  std::vector<FeatureKey> keys;
  std::vector<bool> done;
  std::size_t left = 0;
  std::unique_ptr<formats::RowWriter> rows;
};

FeatureWriter FeatureWriter::create(const fs::path& file, const FeatureInfo& info,
                                    std::vector<FeatureKey> keys) {
  FeatureWriter writer;
  writer.impl_ = std::make_unique<Impl>(file, info, std::move(keys));
  return writer;
}

FeatureWriter::FeatureWriter() = default;
FeatureWriter::~FeatureWriter() = default;
FeatureWriter::FeatureWriter(FeatureWriter&&) noexcept = default;
FeatureWriter& FeatureWriter::operator=(FeatureWriter&&) noexcept = default;

bool FeatureWriter::written(std::size_t row) const {
  EN_CHECK_LT(row, impl_->keys.size());
  return impl_->done[row];
}

std::size_t FeatureWriter::rows_left() const noexcept { return impl_->left; }

void FeatureWriter::write(std::size_t row, std::span<const float> views) {
  EN_CHECK_LT(row, impl_->keys.size());
  EN_CHECK(impl_->rows != nullptr);  // not finished
  impl_->check_numbers(row, views);
  impl_->rows->write(row, views);
  if (!impl_->done[row]) --impl_->left;
  impl_->done[row] = true;
}

void FeatureWriter::finish() {
  EN_CHECK(impl_->rows != nullptr);
  if (impl_->left > 0) {
    const auto missing =
        static_cast<std::size_t>(std::ranges::find(impl_->done, false) - impl_->done.begin());
    throw ArgumentError(fmt::format("{}: {} of {} viewpoints are not written yet, the first of {}",
                                    impl_->file, impl_->left, impl_->keys.size(),
                                    place_of(impl_->keys[missing])));
  }
  impl_->rows->finish();
  impl_->rows.reset();
}

// --- conversion -----------------------------------------------------------------------------

namespace {

std::string text_of(const FeatureInfo& info) {
  std::string text = fmt::format("{} views of {} dimensions", info.views, info.dimensions);
  for (const auto& [name, value] : formats::metadata_of(info)) {
    text += fmt::format(", {} {}", name, quote(value));
  }
  return text;
}

}  // namespace

void convert_features(std::span<const fs::path> from, const fs::path& to, DType type) {
  if (from.empty()) throw ArgumentError(to.string() + ": made of no file");
  std::vector<FeatureSet> sets;
  std::vector<FeatureKey> keys;
  std::unordered_map<std::string, std::size_t> origins;
  for (std::size_t i = 0; i < from.size(); ++i) {
    sets.push_back(FeatureSet::open(from[i]));
    const FeatureInfo &here = sets[i].info(), &first = sets[0].info();
    if (here.views != first.views || here.dimensions != first.dimensions ||
        formats::metadata_of(here) != formats::metadata_of(first)) {
      refuse(from[i].string(), "", "differing-info",
             fmt::format("{}; not {} as in {}", text_of(here), text_of(first), from[0].string()));
    }
    for (const FeatureKey& key : sets[i].keys()) {
      const auto [origin, fresh] = origins.emplace(formats::name_of(key), i);
      if (!fresh) {
        refuse(from[i].string(), place_of(key), "repeated-viewpoint",
               "is in " + from[origin->second].string() + ", too");
      }
      keys.push_back(key);
    }
  }
  FeatureInfo info = sets[0].info();
  info.type = type;
  FeatureWriter writer = FeatureWriter::create(to, info, std::move(keys));
  std::vector<float> views(formats::row_elements(info));
  std::size_t row = 0;
  for (const FeatureSet& set : sets) {
    for (std::size_t i = 0; i < set.keys().size(); ++i, ++row) {
      set.copy_views(i, views);
      writer.write(row, views);
    }
  }
  writer.finish();
}

}  // namespace enfilade::features
