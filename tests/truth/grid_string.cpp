// Finite differences of a string under contacts.
#include "tests/truth/grid_string.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace hapticd {
namespace {

constexpr double kPi = std::numbers::pi;
/// Sweeps over contacts that share a cell end when forces change by no more than this share of all,
/// or this many newtons, which is the rounding of damping.
constexpr double kSweepShare = 1e-12;
constexpr double kSweepForce = 1e-12;
/// Step over the largest stable one: at that itself neighbours no longer hold each other.
constexpr double kOfLargest = 0.99;
constexpr int kMostSweeps = 1000;

double squared(double x) { return x * x; }

/// sum of |differences of a . differences of b|, which is dx times the integral of a_x . b_x.
double slopes(const std::vector<Across>& a, const std::vector<Across>& b, double dx) {
  double sum = 0.0;
  for (std::size_t j = 0; j + 1 < a.size(); ++j) sum += (a[j + 1] - a[j]).dot(b[j + 1] - b[j]);
  return sum / dx;
}

/// The integral of a_xx . b_xx; at hinged ends both are 0.
double bends(const std::vector<Across>& a, const std::vector<Across>& b, double dx) {
  double sum = 0.0;
  for (std::size_t j = 1; j + 1 < a.size(); ++j) {
    sum += (a[j + 1] - 2.0 * a[j] + a[j - 1]).dot(b[j + 1] - 2.0 * b[j] + b[j - 1]);
  }
  return sum / (dx * dx * dx);
}

/// T B / (1 + B) (L/pi)^2, N m^2.
double bending_stiffness(const GridString& string) {
  const double B = string.inharmonicity;
  return string.tension * B / (1.0 + B) * squared(string.length / kPi);
}

/// The largest step that is stable at `dx`: c^2 h^2 + 4 kappa^2 h^2 / dx^2 + 4 s h <= dx^2.
double largest_step(const GridString& string, double density, double dx) {
  const double B = string.inharmonicity;
  const double least = string.tension / (1.0 + B);
  const double added =
      string.axial_stiffness > 0.0 ? (string.largest_tension - 1.0) * string.tension : 0.0;
  const double a =
      (least + added) / density + 4.0 * bending_stiffness(string) / density / squared(dx);
  const double b = 4.0 * string.loss_n2 * squared(string.length / kPi);
  return kOfLargest * 2.0 * dx * dx / (b + std::sqrt(b * b + 4.0 * a * dx * dx));
}

/// What holds the string across a contact.
struct Grip {
  double drag;   ///< damping over the step, N/m
  double limit;  ///< Coulomb's, N
  double bristle;
};

/// Force of a grip on a string that gives way by `give` times it, N, where the contact goes by
/// `way_free` (m) relative to the string that bears nothing of it.
double held(const Grip& grip, double way_free, double give, GridStuck& stuck) {
  const double stiffness = 0.5 * grip.bristle + grip.drag;
  const double force =
      (grip.bristle * stuck.before + stiffness * way_free) / (1.0 + give * stiffness);
  const double way = way_free - give * force;
  const double sticking = grip.bristle * (stuck.before + 0.5 * way);
  stuck.after = stuck.before + way;
  if (std::abs(sticking) <= grip.limit) return force;
  const double slipping = std::copysign(grip.limit, sticking);
  stuck.after = slipping / grip.bristle;
  return (slipping + grip.drag * way_free) / (1.0 + give * grip.drag);
}

}  // namespace

StringGrid::StringGrid(const GridString& string, int cells)
    : string_(string),
      dx_(string.length / std::max(cells, 1)),
      step_(0.0),
      density_(string.tension / squared(2.0 * string.length * string.frequency)) {
  if (cells < 8) throw std::invalid_argument("a string needs at least 8 cells");
  step_ = largest_step(string, density_, dx_);
  const auto size = static_cast<std::size_t>(cells) + 1;
  before_.assign(size, Across::Zero());
  now_ = before_;
  next_ = before_;
}

double StringGrid::added_tension(const std::vector<Across>& u) const {
  if (string_.axial_stiffness == 0.0) return 0.0;
  return string_.axial_stiffness / (2.0 * string_.length) * slopes(u, u, dx_);
}

void StringGrid::let_go(const std::vector<Across>& shape) {
  if (shape.size() != now_.size()) throw std::invalid_argument("one displacement per grid point");
  now_ = shape;
  before_ = now_;
  step_freely();
  // At rest the steps before and after are the same: half of what a step from rest makes.
  for (std::size_t j = 0; j < now_.size(); ++j) before_[j] = now_[j] + 0.5 * (next_[j] - now_[j]);
}

void StringGrid::step_freely() {
  const double B = string_.inharmonicity;
  const double added = added_tension(now_);
  if (added > (string_.largest_tension - 1.0) * string_.tension) {
    throw std::runtime_error("the string is tighter than largest_tension says");
  }
  const double h = step_;
  const double scale = h * h / density_ / squared(dx_);
  const double pull = (string_.tension / (1.0 + B) + added) * scale;
  const double bend = bending_stiffness(string_) * scale / squared(dx_);
  const double smooth = 2.0 * h * string_.loss_n2 * squared(string_.length / kPi / dx_);
  const double loss = string_.loss * h;
  const std::size_t last = now_.size() - 1;
  for (std::size_t j = 1; j < last; ++j) {
    const Across curl = now_[j + 1] - 2.0 * now_[j] + now_[j - 1];
    Across sum = 2.0 * now_[j] - (1.0 - loss) * before_[j] + (pull + smooth) * curl;
    if (smooth > 0.0) sum -= smooth * (before_[j + 1] - 2.0 * before_[j] + before_[j - 1]);
    if (bend > 0.0) {
      const Across left = j >= 2 ? now_[j - 2] : Across(-now_[1]);
      const Across right = j + 2 <= last ? now_[j + 2] : Across(-now_[last - 1]);
      sum -= bend * (left + right - 4.0 * (now_[j - 1] + now_[j + 1]) + 6.0 * now_[j]);
    }
    next_[j] = sum / (1.0 + loss);
  }
}

StringGrid::Point StringGrid::point(double lambda) const {
  const double cells = static_cast<double>(now_.size() - 1);
  const double x = std::clamp(lambda, 0.0, 1.0) * cells;
  const double j = std::min(std::floor(x), cells - 1.0);
  return {static_cast<std::size_t>(j), x - j};
}

Across StringGrid::interpolated(const std::vector<Across>& u, const Point& at) {
  return (1.0 - at.right) * u[at.j] + at.right * u[at.j + 1];
}

Across StringGrid::mean(const Point& at) const {
  return 0.5 * (interpolated(next_, at) + interpolated(before_, at));
}

double StringGrid::yielding(const Point& at) const {
  const double last = static_cast<double>(now_.size() - 1);
  const double left = at.j == 0 ? 0.0 : squared(1.0 - at.right);
  const double right = static_cast<double>(at.j) + 1.0 == last ? 0.0 : squared(at.right);
  return 0.5 * step_ * step_ / (density_ * dx_ * (1.0 + string_.loss * step_)) * (left + right);
}

void StringGrid::push(const Point& at, const Across& force) {
  const double response = step_ * step_ / (density_ * dx_ * (1.0 + string_.loss * step_));
  if (at.j > 0) next_[at.j] += (1.0 - at.right) * response * force;
  if (at.j + 2 < next_.size()) next_[at.j + 1] += at.right * response * force;
}

void StringGrid::place(Finger& finger, const FingerPlace& next) const {
  if (!finger.placed) {
    finger.before = finger.now = next;
    finger.placed = true;
  }
  finger.next = next;
  finger.at = point(finger.now.lambda);
  finger.mean = 0.5 * (finger.next.d + finger.before.d);
  finger.u_before = interpolated(before_, finger.at);
}

// On the string. What it bears moves it away by yielding() times itself, straight from the centre
// and across, so that both parts have closed forms. Velocities are those from the step before to
// the step after, so that damping and friction take just what they should.
void StringGrid::press(Finger& finger) const {
  const GridFinger& of = finger.of;
  const double give = yielding(finger.at);
  const Across u_free = mean(finger.at) - give * finger.touch.force;
  const Across rho_free = finger.mean - u_free;
  const double r_free = rho_free.norm();
  const Across n = rho_free / r_free;
  const Across way_free = (finger.mean - finger.before.d) - (u_free - finger.u_before);
  const double overlap_free = of.radius - r_free;
  double N = (of.stiffness * overlap_free - of.damping / step_ * way_free.dot(n)) /
             (1.0 + give * (of.stiffness + of.damping / step_));
  // Damping neither pulls nor pushes the string out of touch.
  N = std::clamp(N, 0.0, std::max(0.0, overlap_free / give));
  finger.touch.normal = N;
  finger.touch.force = -N * n;
  const Across t{-n.y(), n.x()};
  const Grip grip{of.damping / step_, of.friction * N, of.bristle};
  if (overlap_free > 0.0) {
    finger.touch.force += held(grip, way_free.dot(t), give, finger.stuck) * t;
  } else {
    finger.stuck.after = 0.0;
  }
}

void StringGrid::press(Plane& plane) const {
  const GridPlane& of = plane.of;
  const double give = yielding(plane.at);
  const Across u_free = mean(plane.at) - give * plane.touch.force;
  const double overlap = of.offset - u_free.dot(of.normal);
  const double N = std::max(0.0, of.stiffness * overlap / (1.0 + give * of.stiffness));
  const Across t{-of.normal.y(), of.normal.x()};
  const double way_free = -(u_free - plane.u_before).dot(t);
  plane.touch.normal = N;
  plane.touch.force =
      N * of.normal + held({0.0, of.friction * N, of.bristle}, way_free, give, plane.stuck) * t;
}

bool StringGrid::press_all() {
  double change = 0.0;
  double force = 0.0;
  const auto again = [&](auto& contact) {
    const Across before = contact.touch.force;
    press(contact);
    push(contact.at, contact.touch.force - before);
    change += (contact.touch.force - before).norm();
    force += contact.touch.force.norm();
  };
  for (Finger& finger : fingers_) again(finger);
  for (Plane& plane : planes_) again(plane);
  return change <= kSweepShare * force + kSweepForce;
}

void StringGrid::finish(Finger& finger) {
  finger.stuck.before = finger.stuck.after;
  finger.rho = finger.mean - mean(finger.at);
  const std::size_t left = finger.at.j > 1 ? finger.at.j - 1 : 0;
  const std::size_t right = std::min(finger.at.j + 2, now_.size() - 1);
  const Across slope = (now_[right] - now_[left]) / (dx_ * static_cast<double>(right - left));
  finger.touch.along = -finger.touch.force.dot(slope);
  work_ +=
      0.5 * (finger.touch.force.dot(finger.next.d - finger.before.d) +
             finger.touch.along * string_.length * (finger.next.lambda - finger.before.lambda));
  finger.before = finger.now;
  finger.now = finger.next;
}

void StringGrid::step(const std::vector<FingerPlace>& places) {
  if (places.size() != fingers_.size()) throw std::invalid_argument("one place for each finger");
  step_freely();
  for (std::size_t i = 0; i < places.size(); ++i) place(fingers_[i], places[i]);
  for (Plane& plane : planes_) plane.u_before = interpolated(before_, plane.at);
  for (const Finger& finger : fingers_) push(finger.at, finger.touch.force);
  for (const Plane& plane : planes_) push(plane.at, plane.touch.force);
  for (int sweep = 0; !press_all(); ++sweep) {
    if (sweep == kMostSweeps) throw std::runtime_error("contacts do not settle");
  }
  for (Finger& finger : fingers_) finish(finger);
  for (Plane& plane : planes_) plane.stuck.before = plane.stuck.after;
  before_.swap(now_);
  now_.swap(next_);
  time_ += step_;
}

Across StringGrid::displacement(double lambda) const { return interpolated(now_, point(lambda)); }

StringGrid::Mode StringGrid::mode(int n, double omega) const {
  Mode mode{Across::Zero(), Across::Zero()};
  const double cells = static_cast<double>(now_.size() - 1);
  for (std::size_t j = 1; j + 1 < now_.size(); ++j) {
    const double weight = 2.0 / cells * std::sin(n * kPi * static_cast<double>(j) / cells);
    mode.q += 0.5 * weight * (now_[j] + before_[j]);
    mode.v += weight / (step_ * omega) * (now_[j] - before_[j]);
  }
  return mode;
}

double StringGrid::energy() const {
  double speeds = 0.0;
  for (std::size_t j = 0; j < now_.size(); ++j) speeds += (now_[j] - before_[j]).squaredNorm();
  const double pull = string_.tension / (1.0 + string_.inharmonicity);
  double energy =
      0.5 * density_ * dx_ * speeds / squared(step_) + 0.5 * pull * slopes(now_, before_, dx_);
  if (string_.inharmonicity > 0.0)
    energy += 0.5 * bending_stiffness(string_) * bends(now_, before_, dx_);
  if (string_.axial_stiffness > 0.0) {
    energy += 0.5 * string_.length / string_.axial_stiffness * added_tension(now_) *
              added_tension(before_);
  }
  return energy;
}

double StringGrid::contact_energy() const {
  double energy = 0.0;
  for (const Finger& finger : fingers_) {
    if (finger.touch.normal == 0.0) continue;
    energy += 0.5 * finger.of.stiffness * squared(finger.of.radius - finger.rho.norm()) +
              0.5 * finger.of.bristle * squared(finger.stuck.after);
  }
  for (const Plane& plane : planes_) {
    energy += 0.5 * squared(plane.touch.normal) / plane.of.stiffness +
              0.5 * plane.of.bristle * squared(plane.stuck.after);
  }
  return energy;
}

}  // namespace hapticd
