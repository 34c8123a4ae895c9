// See path_run.h.
#include "tests/truth/path_run.h"

namespace hapticd {

PathRun::PathRun(const Scene& scene, std::size_t tool)
    : scene_(scene), tool_(tool), view_(scene.tool_scene(tool)), judge_(view_) {
  restart();
}

void PathRun::restart() {
  view_ = scene_.tool_scene(tool_);
  work_budget_ = 0;
  state_ = {};
  state_.X_WG = scene_.description().tools[tool_].X_WG;
  result_ = {};
  touched_.clear();
}

void PathRun::note_touched() {
  const SceneDescription& d = scene_.description();
  for (int k = 0; k < state_.active_count; ++k) {
    const ActivePair& pair = state_.active[static_cast<std::size_t>(k)];
    if (!(pair.multiplier > 0.0)) continue;
    const auto index = static_cast<std::size_t>(pair.key.obstacle);
    if (!is_string(pair.key)) {
      touched_.insert(d.bodies[index].name);
      continue;
    }
    const CapsuleOwner& owner = scene_.capsule_owners()[index];
    const auto of = static_cast<std::size_t>(owner.index);
    touched_.insert(owner.is_string ? d.strings[of].name : d.lines[of].name);
  }
}

ContactInput PathRun::tick_input(const Pose& X_WH, double dt) const noexcept {
  ContactInput input = contact_input(view_, X_WH, dt);
  input.work_budget = work_budget_;
  return input;
}

void PathRun::tick(const Pose& X_WH, double dt) {
  problem_->solve(tick_input(X_WH, dt), state_, result_);
  note_touched();
}

double PathRun::judged_tick(const Pose& X_WH, double dt) {
  const ContactInput input = tick_input(X_WH, dt);
  path_.assign(1, state_);
  problem_->begin(input, state_, result_);
  if (problem_->overlaps()) {
    problem_->recover();
    path_.push_back(state_);
    return judge_.smallest_gap(path_);
  }
  for (bool more = true; more && result_.sub_steps < input.options.sub_steps;) {
    problem_->prepare();
    path_.push_back(state_);
    more = problem_->advance() && !problem_->work_used_up();
    path_.push_back(state_);
  }
  problem_->finish();
  note_touched();
  return judge_.smallest_gap(path_);
}

}  // namespace hapticd
