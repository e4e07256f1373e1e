// Render: one picture of what an agent sees, by the names of scan and viewpoint.
//
// The data set is `homes` in the folder that this is run in: three SYNTHETIC model homes, made by
//   enfilade homes --preset small --homes 3 -o homes
#include <enfilade/enfilade.h>

int main() {
  using namespace enfilade;
  const Dataset d("homes");
  save("v.png", render_colour(d, {"home0001", "8d1bc14ed55e8309507ac48f26b0ed4e", 180_deg}));
}
