// See progress_bar.h.
#include "server/model/progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

namespace hapticd {
namespace {

using Seconds = std::chrono::duration<double>;

/// Time between two drawings of the bar: faster is only flicker.
constexpr std::chrono::milliseconds kRedraw{100};
/// Off a terminal a line is printed after this share of the work.
constexpr double kLineEvery = 0.25;
constexpr int kBarWidth = 30;

}  // namespace

ProgressBar::ProgressBar(std::string label, bool quiet)
    : label_(std::move(label)),
      quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) == 1),
      next_(kLineEvery),
      start_(std::chrono::steady_clock::now()) {}

ProgressBar::~ProgressBar() {
  if (drawn_ && terminal_) std::fputs("\r\x1b[K", stderr);
}

void ProgressBar::update(double done) {
  if (quiet_) return;
  done = std::clamp(done, 0.0, 1.0);
  const auto now = std::chrono::steady_clock::now();
  const double spent = Seconds(now - start_).count();
  const double left = done > 0.0 ? spent * (1.0 - done) / done : 0.0;
  if (terminal_) {
    if (drawn_ && now - last_ < kRedraw) return;
    const int full = static_cast<int>(done * kBarWidth);
    std::fprintf(stderr, "\r%s [%.*s%*s] %3.0f %%", label_.c_str(), full,
                 "##############################", kBarWidth - full, "", 100.0 * done);
    if (done > 0.0) std::fprintf(stderr, ", %.0f s left", left);
    std::fputs("\x1b[K", stderr);
    std::fflush(stderr);
  } else if (done >= next_ && done < 1.0) {
    std::fprintf(stderr, "%s: %.0f %%, %.0f s left\n", label_.c_str(), 100.0 * done, left);
    while (next_ <= done) next_ += kLineEvery;
  }
  drawn_ = true;
  last_ = now;
}

}  // namespace hapticd
