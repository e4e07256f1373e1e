// The list of a zip file's entries, and what is in them.
#include <cstddef>
#include <cstdint>
#include <string>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/scan/file_tree.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  try {
    const auto tree = scan::FileTree::zip_in_memory(
        std::string(reinterpret_cast<const char*>(data), size), "<fuzz>");
    // Entries may share their data, so that a small file holds gigabytes; each is bounded, and so
    // is the time for all.
    std::size_t left = std::size_t{32} << 20;
    for (const std::string& name : tree->names()) {
      EN_CHECK(tree->contains(name));
      try {
        const auto start = tree->read_start(name, 100);
        EN_CHECK(start && start->size() <= 100);
        const auto whole = tree->read(name);
        EN_CHECK(whole && whole->starts_with(*start));
        if (whole->size() >= left) break;
        left -= whole->size();
      } catch (const Error&) {
      }
    }
  } catch (const Error&) {
  }
  return 0;
}
