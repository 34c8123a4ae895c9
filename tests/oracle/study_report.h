// What a run of a study comes to: how far it is from the truth of the same input, and what it cost,
// as sums and histograms that add up over runs. Not RT.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/oracle/study_run.h"

namespace hapticd {

/// Bins of a histogram per factor of 2: quantiles are exact to 4.4 %.
inline constexpr int kBinsPerOctave = 16;

/// Counts by the bin floor(kBinsPerOctave log2(value)); values below 1e-3 count as 1e-3.
using Histogram = std::map<int, std::size_t>;
void count_value(double value, Histogram& histogram);
/// Value at or below which the share `q` of what was counted lies: the upper edge of its bin.
[[nodiscard]] double quantile(const Histogram& histogram, double q);

struct StudyErrors {
  std::size_t ticks = 0;
  double felt_square = 0.0;     ///< sum of the squared error of the force, N^2
  double truth_square = 0.0;    ///< of the true force
  double felt_max = 0.0;        ///< N
  double contact_square = 0.0;  ///< the same of what does not vibrate
  double contact_truth_square = 0.0;
  double contact_max = 0.0;
  double torque_square = 0.0;  ///< (N m)^2
  double torque_truth_square = 0.0;
  double pose_square = 0.0;  ///< of the shown tool's origin, m^2
  double pose_max = 0.0;
  double turn_max = 0.0;  ///< rad
};

/// `run` held from tick to tick against `truth`, whose rate is `per_tick` >= 1 times as high.
[[nodiscard]] StudyErrors compare(const std::vector<StudyTick>& run,
                                  const std::vector<StudyTick>& truth, double per_tick);

/// One object of JSON, without an end of line: errors, the smallest gap, work and, under "timing",
/// what differs from run to run. Costs are of the ticks that touch. `surface_m` as the caller says.
[[nodiscard]] std::string study_line(const std::string& name, const std::vector<StudyTick>& run,
                                     const StudyErrors& errors, double surface_m);

/// No point of what is touched with `options` lies further outside its mesh, m; 0 where shapes are
/// exact.
[[nodiscard]] double surface_error(const SceneDescription& scene, std::size_t tool,
                                   const ContactOptions& options);

}  // namespace hapticd
