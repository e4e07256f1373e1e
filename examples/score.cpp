// Score: a results file of a split to a table. This file was written by
//   enfilade run --data homes --split val_unseen --agent random -o results.json
#include <enfilade/enfilade.h>

#include <iostream>

int main() {
  using namespace enfilade;
  const Dataset d("homes");  // made as in render.cpp
  const auto episodes = d.episodes("val_unseen");
  std::cout << to_table(compute_score(load_results("results.json", episodes), episodes));
}
