// One string or two under a straight press, each solved by itself, in series with the coupling, or
// together with the tool, as the daemon does: what either errs and costs. Truth: the coupling's
// force is that of all strings together, Eq. 10 to 12 in long double. SI. Not RT.
#pragma once

#include <vector>

namespace hapticd {

struct PressModel {
  int strings = 1;          ///< pressed at once by one tool
  bool coupled = false;     ///< solved with the tool; else each by the series law
  double error = 0.0;       ///< rms over rms of the truth
  double max_newton = 0.0;  ///< largest error
  double median_ns = 0.0;   ///< of a tick, processor time
};

/// Both ways for one string and two.
[[nodiscard]] std::vector<PressModel> compare_press_models();

}  // namespace hapticd
