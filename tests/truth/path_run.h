// One tool of a scene, led tick by tick, sub-step by sub-step as the loop would (Eq. 5-7), and
// judged along its whole committed path (path_judge.h). Not RT.
#pragma once

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/scene/scene.h"
#include "tests/truth/path_judge.h"

namespace hapticd {

class PathRun {
 public:
  /// The tool begins where the scene says. `scene` must outlive this.
  explicit PathRun(const Scene& scene, std::size_t tool = 0);

  /// As it was made, with the settings of the scene: grids are costly, so that many runs share one.
  void restart();
  /// Puts the tool somewhere; no way leads there.
  void place(const Pose& X_WG) { state_.X_WG = X_WG; }
  /// Stiffness, options, strings and instrument from now on are those of `settings`.
  void follow(const ToolScene& settings) { view_ = settings; }
  /// Work that a tick may take from now on, as ContactInput's; 0: no bound, as at the beginning.
  void allow(std::int64_t work_budget) { work_budget_ = work_budget; }

  /// One tick towards X_WH, not judged; dt in s.
  void tick(const Pose& X_WH, double dt = 1e-3);
  /// The same, and returns the smallest gap on the way, m; at most kFarthestGap.
  double judged_tick(const Pose& X_WH, double dt = 1e-3);

  [[nodiscard]] const Pose& X_WG() const noexcept { return state_.X_WG; }
  [[nodiscard]] const ContactState& state() const noexcept { return state_; }
  [[nodiscard]] const ContactResult& result() const noexcept { return result_; }
  [[nodiscard]] PathJudge& judge() noexcept { return judge_; }
  /// Names of all objects that have carried force so far.
  [[nodiscard]] const std::set<std::string>& touched() const noexcept { return touched_; }

 private:
  [[nodiscard]] ContactInput tick_input(const Pose& X_WH, double dt) const noexcept;
  void note_touched();

  const Scene& scene_;
  std::size_t tool_;
  ToolScene view_;
  PathJudge judge_;
  std::int64_t work_budget_ = 0;
  ContactState state_;
  ContactResult result_;
  std::unique_ptr<ContactProblem> problem_ = std::make_unique<ContactProblem>();
  std::vector<ContactState> path_;  ///< of the tick
  std::set<std::string> touched_;
};

}  // namespace hapticd
