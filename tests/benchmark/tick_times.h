// Times of ticks as tables of tests/benchmark state them: processor time of the thread, which
// leaves out what else the machine does, and quantiles of many. us. Not RT.
#pragma once

#include <algorithm>
#include <ctime>
#include <vector>

namespace hapticd::test {

/// Processor time of this thread, us.
[[nodiscard]] inline double thread_microseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

/// The value that `share` of the values, in [0, 1], stay at or below; 0 of none.
[[nodiscard]] inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto k = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[static_cast<std::size_t>(k)];
}

}  // namespace hapticd::test
