#include "apps/enfilade/subset_option.h"

#include "apps/common/program.h"

namespace enfilade::apps {

void add_subset_option(CLI::App& verb, std::string& subset) {
  add_value(verb, "--subset", subset, "N|FILE|all",
            "N episodes, spread over buildings and lengths (papers: 100, 216, 1000; default: 100, "
            "or as many as there are); or a file with an instruction id a line; or all");
}

}  // namespace enfilade::apps
