// See simulation_fixture.h.
#include "tests/core/simulation/simulation_fixture.h"

#include <algorithm>

namespace hapticd::test {

Instrument::Instrument(int count, const StringParameters& prototype,
                       const InstrumentOptions& options, std::vector<Sphere> spheres)
    : tree_(build_sphere_tree(spheres)) {
  for (int i = 0; i < count; ++i) {
    StringParameters string = prototype;
    string.p_WA = {0.0, 0.0, 0.02 * i};
    string.p_WB = {1.1, 0.0, 0.02 * i};
    if (string.frequency == 0.0 && string.linear_density == 0.0) {
      string.frequency = kTuning[static_cast<std::size_t>(i) % std::size(kTuning)];
    }
    capsules_W.push_back({to_vector(string.p_WA), to_vector(string.p_WB), string.radius});
    strings.push_back(derive_string(string));
  }
  tracks_.resize(strings.size());
  if (options.modes > 0) modes_.resize(strings.size());
  ToolScene scene;
  scene.tool = tree_.view();
  scene.obstacles.capsules_W = capsules_W;
  for (std::size_t i = 0; kCapsulesPerGroup * i < capsules_W.size(); ++i) {
    groups.push_back(group_capsules(capsules_W, i));
  }
  scene.obstacles.groups = groups;
  scene.strings = strings;
  scene.instrument = options;
  simulation_ = std::make_unique<Simulation>(scene, tracks_, modes_);
}

const TickOutput& Instrument::tick(const Pose& X_WH) {
  t_ns += dt_ns;
  p_WH = X_WH.p;
  simulation_->step({{t_ns, to_array(X_WH.p), to_array(X_WH.q)}}, *output_);
  events.insert(events.end(), output_->events.begin(), output_->events.end());
  return *output_;
}

int count(const std::vector<StringEvent>& events, StringEventKind kind) {
  return static_cast<int>(std::count_if(events.begin(), events.end(),
                                        [&](const StringEvent& e) { return e.kind == kind; }));
}

}  // namespace hapticd::test
