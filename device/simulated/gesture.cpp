// See gesture.h.
#include "device/simulated/gesture.h"

#include <algorithm>
#include <cmath>

#include "core/math/rotation.h"

namespace hapticd {
namespace {

constexpr double kNanosecond = 1e-9;
/// Nearer than this to its beginning, m or rad, a gesture needs no way there.
constexpr double kThere = 1e-9;
/// Legs one advance ends at most; legs without duration beyond wait for the next.
constexpr int kMaxLegs = 64;

Pose pose_of(const GesturePoint& point) noexcept {
  return {renormalised(to_quaternion(point.q_DH)), to_vector(point.p_DH)};
}

/// Length of samples, ns.
std::int64_t sampled_ns(const GestureTrack& track) noexcept {
  const double seconds = static_cast<double>(track.samples.size() - 1) / track.rate;
  return static_cast<std::int64_t>(std::ceil(seconds / kNanosecond));
}

double minimum_jerk(double t) noexcept { return t * t * t * (10.0 + t * (6.0 * t - 15.0)); }

/// The pose a share of the way from `a` to a chord and rotation vector beyond it.
Pose between(const Pose& a, const Vector3& chord, const Vector3& turn, double share) noexcept {
  return {renormalised(exp_rotation(share * turn) * a.q), a.p + share * chord};
}

}  // namespace

std::int64_t duration_ns(const GestureTrack& track) noexcept {
  if (!track.samples.empty()) return sampled_ns(track);
  std::int64_t total_ns = 0;
  for (std::size_t i = 0; i < track.legs.size(); ++i) {
    total_ns += track.legs[i].hold_ns + (i > 0 ? track.legs[i].duration_ns : 0);
  }
  return total_ns;
}

void GesturePlayer::play(const GestureTrack& track, std::uint32_t repeat) noexcept {
  playing_ = !track.empty();
  if (!playing_) return;
  track_ = track;
  total_ns_ = duration_ns(track);
  repeat_ = repeat;
  finished_ = 0;
  begin_repetition();
}

void GesturePlayer::rest_at(const Pose& X_DH) noexcept {
  playing_ = false;
  target_ = X_DH;
}

GestureProgress GesturePlayer::progress() const noexcept {
  const bool on_track = phase_ == Phase::kTrack && total_ns_ > 0;
  const std::int64_t into_ns = std::min(done_ns_ + into_ns_, total_ns_);
  const double fraction =
      on_track ? static_cast<double>(into_ns) / static_cast<double>(total_ns_) : 0.0;
  return {playing_, playing_ ? static_cast<float>(fraction) : 0.0F, finished_};
}

void GesturePlayer::begin_motion(const GesturePoint& to, std::int64_t duration_ns,
                                 bool linear) noexcept {
  const Pose X = pose_of(to);
  motion_.from = target_;
  motion_.chord = X.p - target_.p;
  motion_.turn = log_rotation(X.q * target_.q.conjugate());
  motion_.duration_ns = duration_ns;
  motion_.linear = linear;
}

void GesturePlayer::begin_repetition() noexcept {
  phase_ = Phase::kApproach;
  leg_ = 0;
  done_ns_ = into_ns_ = 0;
  begin_motion(track_.legs.empty() ? track_.samples.front() : track_.legs.front().point, 0, false);
  const double far = motion_.chord.norm();
  const double turn = motion_.turn.norm();
  if (far <= kThere && turn <= kThere) {
    phase_ = Phase::kTrack;
    return;
  }
  const double seconds = kMinimumJerkPeak * std::max(far / kApproachSpeed, turn / kApproachTurn);
  // A target a world away still gets there within a century.
  const double ns = std::min(seconds / kNanosecond, 1e18);
  motion_.duration_ns = std::max(kMinApproach_ns, static_cast<std::int64_t>(ns));
}

void GesturePlayer::end_repetition() noexcept {
  if (finished_ < UINT32_MAX) ++finished_;
  if (repeat_ != 0 && finished_ >= repeat_) {
    playing_ = false;
    return;
  }
  const std::int64_t left_ns = into_ns_;
  begin_repetition();
  into_ns_ = left_ns;
}

Pose GesturePlayer::along(double share) const noexcept {
  return between(motion_.from, motion_.chord, motion_.turn,
                 motion_.linear ? share : minimum_jerk(share));
}

bool GesturePlayer::next_leg() noexcept {
  const GestureLeg& over = track_.legs[leg_];
  target_ = pose_of(over.point);
  const std::int64_t leg_ns = over.hold_ns + (leg_ > 0 ? over.duration_ns : 0);
  into_ns_ -= leg_ns;
  done_ns_ += leg_ns;
  if (++leg_ == track_.legs.size()) return false;
  const GestureLeg& next = track_.legs[leg_];
  begin_motion(next.point, next.duration_ns, next.linear);
  return true;
}

void GesturePlayer::walk_legs() noexcept {
  for (int ended = 0; ended < kMaxLegs && playing_ && phase_ == Phase::kTrack; ++ended) {
    const GestureLeg& leg = track_.legs[leg_];
    const std::int64_t moving_ns = leg_ > 0 ? leg.duration_ns : 0;
    if (into_ns_ < moving_ns) {
      target_ = along(static_cast<double>(into_ns_) / static_cast<double>(moving_ns));
      return;
    }
    if (into_ns_ < moving_ns + leg.hold_ns) {
      target_ = pose_of(leg.point);
      return;
    }
    if (!next_leg()) end_repetition();
  }
}

void GesturePlayer::walk_samples() noexcept {
  if (into_ns_ >= total_ns_) {
    target_ = pose_of(track_.samples.back());
    into_ns_ -= total_ns_;
    end_repetition();
    return;
  }
  const double place = static_cast<double>(into_ns_) * kNanosecond * track_.rate;
  const double whole = std::floor(place);
  const std::size_t i = std::min(static_cast<std::size_t>(whole), track_.samples.size() - 2);
  const Pose a = pose_of(track_.samples[i]);
  const Pose b = pose_of(track_.samples[i + 1]);
  target_ = between(a, b.p - a.p, log_rotation(b.q * a.q.conjugate()), place - whole);
}

const Pose& GesturePlayer::advance(std::int64_t dt_ns) noexcept {
  if (!playing_) return target_;
  into_ns_ += dt_ns;
  if (phase_ == Phase::kApproach) {
    if (into_ns_ < motion_.duration_ns) {
      target_ = along(static_cast<double>(into_ns_) / static_cast<double>(motion_.duration_ns));
      return target_;
    }
    into_ns_ -= motion_.duration_ns;
    phase_ = Phase::kTrack;
    target_ = pose_of(track_.legs.empty() ? track_.samples.front() : track_.legs.front().point);
  }
  if (track_.samples.empty()) {
    walk_legs();
  } else {
    walk_samples();
  }
  return target_;
}

}  // namespace hapticd
