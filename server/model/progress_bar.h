// Progress of a long command on stderr: a bar with the time left on a terminal, a few lines
// elsewhere. Not RT.
#pragma once

#include <chrono>
#include <string>

namespace hapticd {

class ProgressBar {
 public:
  /// Says nothing at all when `quiet`.
  ProgressBar(std::string label, bool quiet);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// `done` in [0, 1]; cheap to call often.
  void update(double done);

 private:
  std::string label_;
  bool quiet_;
  bool terminal_;
  bool drawn_ = false;
  double next_ = 0.0;  ///< share from which the next line is printed, off a terminal
  std::chrono::steady_clock::time_point start_, last_;
};

}  // namespace hapticd
