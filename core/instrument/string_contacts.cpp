// Sub-steps of a string under contacts: each contact's force by Newton's method in its own frame,
// several by sweeps over them.
#include "core/instrument/string_contacts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace hapticd {
namespace {

constexpr std::size_t kMost = kMaxStringContacts;
/// Overlap below which damping fades, m: it would begin with a jump.
constexpr double kDampingDepth = 50e-6;
/// b stays above the pole of a round contact's response, at -1/a, beyond which roots are false.
constexpr double kAbovePole = 0.9;
/// Distances below which a centre is on the string's axis, m: from there no way out is nearer.
constexpr double kLeastDistance = 1e-12;
constexpr int kNewtonSteps = 24;
/// Newton's steps of a contact in the first sweep and in each later one.
constexpr int kFirstSteps = 2;
/// Sweeps; from the fallback on round contacts keep their tangent plane.
constexpr int kSweeps = 64;
constexpr int kFallback = 48;
/// Sweeps end when forces change by no more than this share of their sum, and this, N.
constexpr double kSweepShare = 1e-10;
constexpr double kSweepForce = 1e-12;
/// Newton's steps end where the force is missed by less: as a share of it, in N, and as a share of
/// what a distance is rounded by.
constexpr double kNewtonShare = 1e-13;
constexpr double kNewtonForce = 1e-14;
constexpr double kRounding = 1e-16;
/// A b that misses its own by more force than this is none.
constexpr double kRootShare = 1e-10;
constexpr double kRootForce = 1e-12;

double dot(const Transverse& a, const Transverse& b) noexcept { return a.y * b.y + a.z * b.z; }
Transverse minus(const Transverse& a, const Transverse& b) noexcept {
  return {a.y - b.y, a.z - b.z};
}
Transverse along(const Transverse& a, double factor, const Transverse& b) noexcept {
  return {a.y + factor * b.y, a.z + factor * b.z};
}

/// A contact within a sub-step, in its own frame: n from the string to it, t across.
struct Pressed {
  PerMode shapes;
  PerMode slide;  ///< what is added to the shapes in each sub-step
  StringContactPath* path = nullptr;
  double radius = 0.0, radius_step = 0.0;
  Transverse d, d_step;
  Transverse u;     ///< of the string at its place
  double k = 0.0;   ///< stiffness with what the modes leave out in series
  double ka = 0.0;  ///< the bristle's with it
  double c = 0.0;   ///< damping in series with it, of a whole touch, over the step, N/m
  double a = 0.0;   ///< what a unit force moves the string by in a sub-step
  Transverse n, t;
  double r0 = 0.0;  ///< distance at the start; of a plane: depth
  double y0 = 0.0;  ///< along t at the start: 0 but for planes
  double g = 0.0;   ///< damping over the step, N/m
  double limit = 0.0;
  Transverse rho_free;  ///< at the end, without any contact's force
  Transverse force;     ///< on the string, N
  double after = 0.0;   ///< the bristle at the end, m
  bool slides = false;
  bool rooted = false;  ///< b is that of the force
};

double squared(double x) noexcept { return x * x; }

/// (V(to) - V(from)) / (to^2 - from^2), V = k max(0, s - r)^2 / 2, without cancellation.
double round_gradient(double k, double s, double from, double to) noexcept {
  const double sum = std::max(from + to, kLeastDistance);
  if (from < s && to < s) return k * (sum - 2.0 * s) / (2.0 * sum);
  if (from < s) return -0.5 * k * squared(s - from) / (to * to - from * from);
  if (to < s) return 0.5 * k * squared(s - to) / (to * to - from * from);
  return 0.0;
}

/// Its derivative by `to`.
double round_curvature(double k, double s, double from, double to) noexcept {
  if (from < s && to < s) return k * s / squared(std::max(from + to, kLeastDistance));
  const double b = round_gradient(k, s, from, to);
  if (from < s) return -2.0 * to * b / (to * to - from * from);
  if (to < s) return (-k * (s - to) - 2.0 * to * b) / (to * to - from * from);
  return 0.0;
}

/// (V(to) - V(from)) / (to - from), V = k max(0, o)^2 / 2.
double plane_gradient(double k, double from, double to) noexcept {
  const double low = std::max(0.0, from);
  const double high = std::max(0.0, to);
  if (from == to) return k * low;
  return 0.5 * k * (high - low) * (high + low) / (to - from);
}

/// Its derivative by `to`.
double plane_curvature(double k, double from, double to) noexcept {
  if (from > 0.0 && to > 0.0) return 0.5 * k;
  if (from == to) return 0.0;
  const double gradient = plane_gradient(k, from, to);
  if (to > 0.0) return (k * to - gradient) / (to - from);
  return gradient / (from - to);
}

double potential(const Pressed& contact, const Transverse& u) noexcept {
  const StringContactPath& path = *contact.path;
  const Transverse rho = minus(contact.d, u);
  const double o = path.shape == StringContactShape::kRound
                       ? contact.radius - std::sqrt(dot(rho, rho))
                       : dot(rho, path.normal);
  return 0.5 * contact.k * squared(std::max(0.0, o));
}

/// How the string moves across a contact: by friction, the bristle and damping; `slope` is what the
/// potential itself adds. Returns the force on the string along t.
double hold(const Pressed& contact, double y_free, double slope, double limit,
            double& after) noexcept {
  const double a = contact.a;
  const double rest = slope + contact.g;
  if (contact.path->friction == 0.0) {
    after = 0.0;
    return rest * y_free / (1.0 + a * rest);
  }
  const double z0 = contact.path->stretched;
  double y = (y_free - a * contact.ka * z0) / (1.0 + a * (rest + 0.5 * contact.ka));
  double f = contact.ka * (z0 + 0.5 * y);
  if (std::abs(f) > limit) {
    f = f > 0.0 ? limit : -limit;
    y = (y_free - a * f) / (1.0 + a * rest);
    after = std::clamp(z0 + y, -limit / contact.ka, limit / contact.ka);
  } else {
    after = z0 + y;
  }
  return f + rest * y;
}

/// From the string to a contact, in its frame, m.
struct InFrame {
  double x;  ///< along n
  double y;  ///< along t
};

/// What b leads to.
struct RoundTrial {
  double x, y;         ///< where the contact then is from the string, along n and t, m
  double r;            ///< and how far, m
  double b;            ///< that belongs to it, N/m
  double normal;       ///< force along n, N
  double tangential;   ///< and along t, N
  double after = 0.0;  ///< the bristle at the end, m
};

/// `free`: at the end, without the contact's own force.
RoundTrial try_round(const Pressed& contact, const InFrame& free, double b) noexcept {
  const double a = contact.a;
  const double g = contact.g;
  const double r0 = contact.r0;
  RoundTrial trial{};
  trial.x = (free.x + a * (g - b) * r0) / (1.0 + a * (b + g));
  double pull = g * (trial.x - r0);
  const double N = -b * (r0 + trial.x);
  if (pull > N) {
    pull = N;
    trial.x = free.x;
  }
  trial.normal = pull - N;
  const double limit = contact.path->friction * std::max(0.0, N - pull);
  trial.tangential = hold(contact, free.y, b, limit, trial.after);
  trial.y = free.y - a * trial.tangential;
  trial.r = std::sqrt(trial.x * trial.x + trial.y * trial.y);
  trial.b = round_gradient(contact.k, contact.radius, r0, trial.r);
  return trial;
}

/// The tangent plane at the start for the circle.
void solve_plane(Pressed& contact, const Transverse& rho, double from, double depth_sign,
                 double depth_offset) noexcept {
  const double a = contact.a;
  // Depth o: of a plane n . rho, of a circle's tangent plane radius - n . rho.
  const double o_free = depth_offset + depth_sign * dot(rho, contact.n);
  double o = (o_free - a * (0.5 * contact.k - contact.g) * from) /
             (1.0 + a * (0.5 * contact.k + contact.g));
  double N = 0.0;
  for (int step = 0; step < kNewtonSteps; ++step) {
    N = plane_gradient(contact.k, from, o) + contact.g * (o - from);
    const double miss = o - o_free + a * N;
    const double change = miss / (1.0 + a * (plane_curvature(contact.k, from, o) + contact.g));
    o -= change;
    if (std::abs(change) <= kNewtonShare * std::abs(o_free)) break;
  }
  N = std::max(0.0, plane_gradient(contact.k, from, o) + contact.g * (o - from));
  const double f = hold(contact, dot(rho, contact.t) - contact.y0, 0.0, contact.path->friction * N,
                        contact.after);
  contact.rooted = true;
  const double along_n = depth_sign > 0.0 ? N : -N;
  contact.force = {along_n * contact.n.y + f * contact.t.y,
                   along_n * contact.n.z + f * contact.t.z};
}

/// By how much force b misses that of where it leads to, N.
double miss_of(const Pressed& contact, const RoundTrial& trial, double b) noexcept {
  return std::abs(trial.b - b) * (contact.r0 + std::abs(trial.x));
}

/// `rho`: at the end, without the contact's own force.
void solve_round(Pressed& contact, const Transverse& rho, int steps) noexcept {
  const InFrame free{dot(rho, contact.n), dot(rho, contact.t)};
  const double lowest = -kAbovePole / contact.a - contact.g;
  // What distances are rounded by is nothing that a step could mend.
  const double least = kNewtonForce + kRounding * contact.k * contact.radius;
  double b = std::max(contact.path->slope, lowest);
  RoundTrial trial = try_round(contact, free, b);
  for (int step = 0; step < steps; ++step) {
    if (miss_of(contact, trial, b) <= kNewtonShare * std::abs(trial.normal) + least) break;
    const double curvature = round_curvature(contact.k, contact.radius, contact.r0, trial.r);
    const double swing = -contact.a * (contact.r0 + trial.x) / (1.0 + contact.a * (b + contact.g));
    const double slope = trial.r > 0.0 ? curvature * trial.x / trial.r * swing : 0.0;
    const double next = std::max(b - (b - trial.b) / std::max(1.0 - slope, 0.1), lowest);
    if (next == b) break;
    b = next;
    trial = try_round(contact, free, b);
  }
  contact.path->slope = b;
  contact.after = trial.after;
  contact.force = {trial.normal * contact.n.y + trial.tangential * contact.t.y,
                   trial.normal * contact.n.z + trial.tangential * contact.t.z};
  contact.rooted = trial.x > 0.0 &&
                   miss_of(contact, trial, b) <= kRootShare * std::abs(trial.normal) + kRootForce;
}

/// All contacts of a string over a tick, one at least.
class Sweeps {
 public:
  Sweeps(const StringConstants& string, const ModeTable& table, int steps,
         StringContactPaths& contacts, ModalMotion& motion) noexcept
      : string_(string), table_(table), motion_(motion), count_(contacts.size()) {
    for (std::size_t i = 0; i < count_; ++i) take(contacts[i], steps, pressed_[i]);
    couple();
  }

  /// One sub-step. False where a round contact kept its tangent plane.
  bool step() noexcept {
    for (std::size_t i = 0; i < count_; ++i) place(pressed_[i]);
    if (slides_) couple();
    for (std::size_t i = 0; i < count_; ++i) {
      Pressed& contact = pressed_[i];
      const Transverse u_free = i == 0 ? turn(table_, contact.shapes, motion_)
                                       : displacement(table_, motion_, contact.shapes);
      contact.d = along(contact.d, 1.0, contact.d_step);
      contact.rho_free = minus(contact.d, u_free);
    }
    const bool well = count_ == 1 ? solve_one() : solve_all();
    for (std::size_t i = 0; i < count_; ++i) finish(i);
    ++now_;
    return well;
  }

  /// At the end of the tick.
  void leave() noexcept {
    for (std::size_t i = 0; i < count_; ++i) {
      const Pressed& contact = pressed_[i];
      contact.path->stored =
          potential(contact, contact.u) + 0.5 * contact.ka * squared(contact.path->stretched);
    }
  }

 private:
  void take(StringContactPath& path, int steps, Pressed& contact) noexcept {
    contact.path = &path;
    contact.shapes = PerMode{};
    mode_shapes(table_, path.lambda_from, contact.shapes);
    contact.slides = path.lambda_from != path.lambda_to;
    slides_ = slides_ || contact.slides;
    const double share = 1.0 / steps;
    if (contact.slides) {
      contact.slide = PerMode{};
      mode_shapes(table_, path.lambda_to, contact.slide);
      for (std::size_t i = 0; i < static_cast<std::size_t>(table_.count); ++i) {
        contact.slide[i] = (contact.slide[i] - contact.shapes[i]) * share;
      }
    }
    contact.radius = path.radius_from > 0.0 ? path.radius_from : path.radius;
    contact.radius_step = (path.radius - contact.radius) * share;
    contact.d = path.d_from;
    contact.d_step = {(path.d_to.y - path.d_from.y) * share, (path.d_to.z - path.d_from.z) * share};
    const double middle = 0.5 * (path.lambda_from + path.lambda_to);
    const double residual = residual_compliance(string_, table_, middle, contact.shapes);
    contact.k = 1.0 / (1.0 / path.stiffness + residual);
    contact.ka = 1.0 / (1.0 / path.bristle + residual);
    // Of what the modes move by at the contact, only this share is the contact's own.
    contact.c = path.damping / table_.step * squared(contact.k / path.stiffness);
    contact.u = displacement(table_, motion_, contact.shapes);
    contact.a = response(table_, contact.shapes, contact.shapes);
    path.force = {};
    // What the place changes of the stiffness is the path's work, too.
    path.work =
        potential(contact, contact.u) + 0.5 * contact.ka * squared(path.stretched) - path.stored;
    path.touched = 0;
    path.first = -1;
    path.last = -1;
    share_ = share;
  }

  /// What forces at one contact move the string by at another.
  void couple() noexcept {
    for (std::size_t i = 0; i < count_; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        response_[i][j] = response_[j][i] =
            response(table_, pressed_[i].shapes, pressed_[j].shapes);
      }
    }
  }

  // The contact slides and grows first, and carries its potential along; then its frame is set.
  void place(Pressed& contact) noexcept {
    StringContactPath& path = *contact.path;
    if (contact.slides || contact.radius_step != 0.0) {
      const double before = potential(contact, contact.u);
      contact.radius += contact.radius_step;
      if (contact.slides) {
        const PlaceOfString at = slide(table_, motion_, contact.slide, contact.shapes);
        contact.u = at.u;
        contact.a = at.response;
      }
      path.work += potential(contact, contact.u) - before;
    }
    const Transverse rho = minus(contact.d, contact.u);
    double depth = 0.0;
    if (path.shape == StringContactShape::kRound) {
      contact.r0 = std::sqrt(dot(rho, rho));
      contact.n = contact.r0 > 0.0 ? Transverse{rho.y / contact.r0, rho.z / contact.r0}
                                   : Transverse{0.0, 1.0};
      depth = contact.radius - contact.r0;
    } else {
      contact.n = path.normal;
      contact.r0 = dot(rho, path.normal);
      depth = contact.r0;
    }
    contact.t = {-contact.n.z, contact.n.y};
    contact.y0 = path.shape == StringContactShape::kPlane ? dot(rho, contact.t) : 0.0;
    contact.g = contact.c * std::clamp(depth / kDampingDepth, 0.0, 1.0);
    contact.force = {};
  }

  /// By up to `steps` of Newton's, or its tangent plane where those are 0.
  static void solve(Pressed& contact, const Transverse& rho, int steps) noexcept {
    const StringContactPath& path = *contact.path;
    if (path.shape == StringContactShape::kPlane) {
      solve_plane(contact, rho, contact.r0, 1.0, 0.0);
    } else if (steps > 0) {
      solve_round(contact, rho, steps);
    } else {
      solve_plane(contact, rho, contact.radius - contact.r0, -1.0, contact.radius);
    }
  }

  bool solve_one() noexcept {
    Pressed& contact = pressed_[0];
    solve(contact, contact.rho_free, kNewtonSteps);
    if (contact.rooted) return true;
    solve(contact, contact.rho_free, 0);
    return false;
  }

  bool solve_all() noexcept {
    std::array<bool, kMost> as_plane{};
    bool well = true;
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      double change = 0.0;
      double sum = 0.0;
      bool rooted = true;
      for (std::size_t i = 0; i < count_; ++i) {
        Pressed& contact = pressed_[i];
        Transverse rho = contact.rho_free;
        for (std::size_t j = 0; j < count_; ++j) {
          if (j != i) rho = along(rho, -response_[i][j], pressed_[j].force);
        }
        const Transverse before = contact.force;
        solve(contact, rho, as_plane[i] ? 0 : sweep == 0 ? kFirstSteps : 1);
        rooted = rooted && contact.rooted;
        change += std::abs(contact.force.y - before.y) + std::abs(contact.force.z - before.z);
        sum += std::abs(contact.force.y) + std::abs(contact.force.z);
      }
      if (rooted && change <= kSweepShare * sum + kSweepForce) return well;
      if (sweep + 1 != kFallback) continue;
      for (std::size_t i = 0; i < count_; ++i) {
        as_plane[i] = true;
        well = false;
      }
    }
    return false;
  }

  void finish(std::size_t i) noexcept {
    Pressed& contact = pressed_[i];
    StringContactPath& path = *contact.path;
    push(table_, contact.shapes, contact.force, motion_);
    Transverse rho = along(contact.rho_free, -contact.a, contact.force);
    for (std::size_t j = 0; j < count_; ++j) {
      if (j != i) rho = along(rho, -response_[i][j], pressed_[j].force);
    }
    contact.u = minus(contact.d, rho);
    path.work += dot(contact.force, contact.d_step);
    path.force = along(path.force, share_, contact.force);
    const bool touches = contact.force.y != 0.0 || contact.force.z != 0.0;
    if (touches) {
      ++path.touched;
      path.last = now_;
      if (path.first < 0) path.first = now_;
    }
    path.stretched = touches ? contact.after : 0.0;
  }

  std::array<Pressed, kMost> pressed_;
  const StringConstants& string_;
  const ModeTable& table_;
  ModalMotion& motion_;
  std::size_t count_;
  double share_ = 1.0;
  int now_ = 0;  ///< number of the sub-step
  bool slides_ = false;
  /// Of one contact to another, m/N; that to itself is Pressed::a.
  std::array<std::array<double, kMost>, kMost> response_;
};

}  // namespace

int play(const StringConstants& string, const ModeTable& table, int steps,
         StringContactPaths& contacts, ModalMotion& motion) noexcept {
  if (contacts.empty()) {
    for (int step = 0; step < steps; ++step) turn(table, PerMode{}, motion);
    return 0;
  }
  int fallbacks = 0;
  Sweeps sweeps(string, table, steps, contacts, motion);
  for (int step = 0; step < steps; ++step) fallbacks += sweeps.step() ? 0 : 1;
  sweeps.leave();
  return fallbacks;
}

}  // namespace hapticd
