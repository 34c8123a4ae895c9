// See ensemble.h.
#include "tests/core/simulation/ensemble.h"

#include <algorithm>
#include <limits>

#include "tests/support/string_shape.h"
#include "tests/truth/contact_oracle.h"

namespace hapticd::test {
namespace {

constexpr double kTunings[] = {65.4, 73.4, 87.3, 98.0, 110.0, 130.8, 146.8};

}  // namespace

Ensemble::Ensemble(std::size_t tools, const EnsembleOptions& options)
    : options_(options), tool_(build_sphere_tree(options.tool)) {
  for (int i = 0; i < options.strings; ++i) {
    StringParameters string = options.string;
    string.p_WA = {0.0, 0.0, 0.02 * i};
    string.p_WB = {kEnsembleLength, 0.0, 0.02 * i};
    if (options.tuned) string.frequency = kTunings[i % 7];
    capsules_W_.push_back({to_vector(string.p_WA), to_vector(string.p_WB), string.radius});
    strings_.push_back(derive_string(string));
  }
  groups_.push_back(group_capsules(capsules_W_, 0));
  for (int i = 0; i < 12; ++i) {
    for (int k = 0; k < 3; ++k) {
      body_spheres_.push_back({{0.1 * i, options.body_y - 0.1, 0.06 * k}, 0.1});
    }
  }
  body_ = build_sphere_tree(body_spheres_);
  bodies_.push_back({body_.view(), {}});
  ToolScene scene;
  scene.tool = tool_.view();
  scene.obstacles = {capsules_W_, bodies_, {}, groups_, groups_[0]};
  scene.strings = strings_;
  scene.instrument = options.instrument;
  play_ = own_simulation(std::vector<ToolScene>(tools, scene));
}

std::vector<HandPose> Ensemble::hands(const std::vector<Vector3>& p_WH) const {
  std::vector<HandPose> hands;
  hands.reserve(p_WH.size());
  for (const Vector3& p : p_WH) {
    hands.push_back({t_ns_ + 1'000'000, to_array(p), {1.0, 0.0, 0.0, 0.0}});
  }
  return hands;
}

const SimulationTick& Ensemble::tick(const std::vector<Vector3>& p_WH) {
  output_.step(*play_.simulation, hands(p_WH), work_budget);
  t_ns_ += 1'000'000;
  events.insert(events.end(), output_.events().begin(), output_.events().end());
  return output_;
}

StringPoints Ensemble::shape(std::int32_t string) const {
  return string_shape(*play_.simulation, string);
}

long double Ensemble::minimum_gap() const {
  std::vector<Capsule> legs;
  for (std::size_t s = 0; s < strings_.size(); ++s) {
    const StringPoints points = shape(static_cast<std::int32_t>(s));
    for (std::size_t k = 0; k + 1 < points.size(); ++k) {
      legs.push_back({points[k], points[k + 1], capsules_W_[s].r});
    }
  }
  const OracleBody body{body_spheres_, {}};
  long double gap = std::numeric_limits<long double>::infinity();
  for (const ToolPlay& tool : play_.tools) {
    const Pose& X_WG = tool.rendered.X_WG;
    gap = std::min(gap, exhaustive_minimum_gap(options_.tool, X_WG, {legs, {&body, 1}}));
  }
  return gap;
}

}  // namespace hapticd::test
