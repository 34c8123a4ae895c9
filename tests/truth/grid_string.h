// A string that fingers and planes touch while it swings, in both planes across it, computed
// offline: the truth for strings that are played, of which it shares no code and no method. Central
// finite differences of
//   mu u_tt = (T / (1 + B) + T_a) u_xx - T B / (1 + B) (L/pi)^2 u_xxxx
//             - 2 mu (sigma_0 u_t - sigma_1 (L/pi)^2 u_txx),      T_a = E A / (2 L) integral
//             |u_x|^2 dx,
// hinged at both ends, stepped explicitly at the largest step that is stable (S. Bilbao, "Numerical
// Sound Synthesis", 2009, 7.2), which without stiffness and loss is d'Alembert's solution. Contacts
// see the mean of the step before and after, so springs of any stiffness are stable and lose
// nothing in the limit. SI; the string lies along x, places along it are lambda = x / L. Not RT.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace hapticd {

/// Across the string, (y, z).
using Across = Eigen::Vector2d;

struct GridString {
  double length = 1.1;           ///< m
  double tension = 30.0;         ///< at rest, N
  double frequency = 65.4;       ///< f_1, Hz
  double inharmonicity = 0.0;    ///< B: f_n = n f_1 sqrt((1 + B n^2) / (1 + B))
  double loss = 2.0;             ///< sigma_0, 1/s: mode n decays by exp(-(sigma_0 + n^2 sigma_1) t)
  double loss_n2 = 0.002;        ///< sigma_1, 1/s
  double axial_stiffness = 0.0;  ///< E A, N; 0: the tension is constant
  double largest_tension = 1.25;  ///< (T + T_a) / T, which the step must bear where E A > 0
};

/// A round finger or plectrum, whose centre is led along a path. What a tool gives way by is in its
/// stiffness, as a spring in series.
struct GridFinger {
  double radius = 5.34e-3;    ///< of finger and string together, m
  double stiffness = 1000.0;  ///< of the overlap, N/m
  double damping = 0.0;       ///< N s/m, in touch, every way; it never pulls
  double friction = 0.0;      ///< Coulomb's, across the string
  double bristle = 2e4;       ///< stiffness of what sticks, N/m
};

/// Where a finger is.
struct FingerPlace {
  double lambda = 0.5;
  Across d{1.0, 1.0};  ///< centre, m
};

/// A fret, or a board: the string is kept on the side that `normal` points to.
struct GridPlane {
  double lambda = 0.5;
  Across normal{0.0, 1.0};  ///< unit
  double offset = 0.0;      ///< of its surface along the normal, for the string's axis, m
  double stiffness = 1e6;   ///< N/m
  double friction = 0.0;    ///< Coulomb's, across the string
  double bristle = 1e6;     ///< N/m
};

/// How far what sticks is stretched, half a step before and after, m.
struct GridStuck {
  double before = 0.0;
  double after = 0.0;
};

/// What a contact does to the string after a step.
struct GridTouch {
  Across force{0.0, 0.0};  ///< on the string, N
  double normal = 0.0;     ///< N
  double along = 0.0;      ///< on the finger along x: what it must be pushed with to slide, N
};

class StringGrid {
 public:
  /// `cells` intervals, at least 8; the string rests. Throws std::invalid_argument for fewer.
  StringGrid(const GridString& string, int cells);

  void add(const GridFinger& finger) { fingers_.emplace_back(finger); }
  void add(const GridPlane& plane) { planes_.emplace_back(plane, point(plane.lambda)); }

  /// Draws the string to `shape`, displacements at its cells + 1 grid points, and lets it go.
  void let_go(const std::vector<Across>& shape);

  /// One step of step_s(), at whose end the fingers are at `places`. Throws std::invalid_argument
  /// unless there is one for each, std::runtime_error where the tension exceeds what the step
  /// bears.
  void step(const std::vector<FingerPlace>& places);

  [[nodiscard]] double step_s() const { return step_; }
  [[nodiscard]] double time() const { return time_; }
  /// Displacement at `lambda`, m.
  [[nodiscard]] Across displacement(double lambda) const;

  /// T + T_a, N.
  [[nodiscard]] double tension() const { return string_.tension + added_tension(now_); }

  /// Of a mode, both planes, m.
  struct Mode {
    Across q;  ///< (2/L) integral u sin(n pi x / L) dx
    Across v;  ///< the same of u_t / omega
  };
  /// Mode n half a step ago; `omega` in rad/s.
  [[nodiscard]] Mode mode(int n, double omega) const;
  /// Kinetic and potential energy of the string half a step ago, J; of its contacts not.
  [[nodiscard]] double energy() const;
  /// In the springs of all contacts, J.
  [[nodiscard]] double contact_energy() const;
  /// What the fingers' paths have put in, across and along the string, J.
  [[nodiscard]] double work() const { return work_; }
  [[nodiscard]] const GridTouch& finger(std::size_t i) const { return fingers_[i].touch; }
  [[nodiscard]] const GridTouch& plane(std::size_t i) const { return planes_[i].touch; }

 private:
  /// A place between two grid points.
  struct Point {
    std::size_t j = 1;
    double right = 0.0;  ///< weight of j + 1; the rest is of j
  };
  struct Finger {
    explicit Finger(const GridFinger& finger) : of(finger) {}
    GridFinger of;
    Point at;
    FingerPlace before, now, next;
    bool placed = false;
    Across mean{0.0, 0.0};      ///< of the centre before and after, m
    Across u_before{0.0, 0.0};  ///< of the string where it touches, a step before, m
    Across rho{1.0, 1.0};       ///< from string to finger, mean of before and after, m
    GridStuck stuck;
    GridTouch touch;
  };
  struct Plane {
    Plane(const GridPlane& plane, const Point& point) : of(plane), at(point) {}
    GridPlane of;
    Point at;
    Across u_before{0.0, 0.0};
    GridStuck stuck;
    GridTouch touch;
  };

  void step_freely();
  void place(Finger& finger, const FingerPlace& next) const;
  [[nodiscard]] bool press_all();
  void press(Finger& finger) const;
  void press(Plane& plane) const;
  void push(const Point& at, const Across& force);
  [[nodiscard]] Point point(double lambda) const;
  [[nodiscard]] static Across interpolated(const std::vector<Across>& u, const Point& at);
  [[nodiscard]] Across mean(const Point& at) const;
  [[nodiscard]] double yielding(const Point& at) const;
  [[nodiscard]] double added_tension(const std::vector<Across>& u) const;
  void finish(Finger& finger);

  GridString string_;
  double dx_;       ///< m
  double step_;     ///< s
  double density_;  ///< mu, kg/m
  double time_ = 0.0, work_ = 0.0;
  std::vector<Across> before_, now_, next_;
  std::vector<Finger> fingers_;
  std::vector<Plane> planes_;
};

}  // namespace hapticd
