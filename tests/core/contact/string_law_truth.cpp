// See string_law_truth.h.
#include "tests/core/contact/string_law_truth.h"

#include <algorithm>
#include <cmath>

namespace hapticd::test {
namespace {

using Real = long double;

constexpr Real kPi = 3.14159265358979323846264338328L;
/// Halvings of a bracket: more than the bits of a long double.
constexpr int kHalvings = 200;

/// Length of a half of the string minus its run.
Real stretch(Real run, Real delta) {
  return delta > 0 ? delta * (delta / (std::hypot(run, delta) + run)) : 0;
}

/// The triangle of a deflected string.
struct Bent {
  Real run_1, run_2;
  Real ext;
  Real tension;  ///< T + F_i

  Bent(const LawString& string, Real lambda, Real delta)
      : run_1(lambda * string.length),
        run_2((1 - lambda) * string.length),
        ext(stretch(run_1, delta) + stretch(run_2, delta)),
        tension(string.tension + string.axial * ext / string.length) {}
};

/// Root of the growing function `f` in [0, high].
template <typename Function>
Real bisect(Real high, const Function& f) {
  Real low = 0;
  for (int i = 0; i < kHalvings; ++i) {
    const Real middle = (low + high) / 2;
    (f(middle) < 0 ? low : high) = middle;
  }
  return (low + high) / 2;
}

}  // namespace

LawString law_string(const StringParameters& parameters) {
  Real square = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Real d = static_cast<Real>(parameters.p_WB[k]) - static_cast<Real>(parameters.p_WA[k]);
    square += d * d;
  }
  const Real R = parameters.radius;
  return {std::sqrt(square), parameters.tension,
          static_cast<Real>(parameters.youngs_modulus) * kPi * R * R, parameters.contact_stiffness};
}

Real law_force(const LawString& string, Real lambda, Real delta) {
  if (!(delta > 0)) return 0;
  const Bent bent(string, lambda, delta);
  return bent.tension *
         (delta / std::hypot(bent.run_1, delta) + delta / std::hypot(bent.run_2, delta));
}

Real law_energy(const LawString& string, Real lambda, Real delta) {
  const Bent bent(string, lambda, delta);
  return string.tension * bent.ext + string.axial * bent.ext * bent.ext / (2 * string.length);
}

Real law_lateral(const LawString& string, Real lambda, Real delta) {
  const Bent bent(string, lambda, delta);
  return bent.tension *
         (bent.run_2 / std::hypot(bent.run_2, delta) - bent.run_1 / std::hypot(bent.run_1, delta));
}

Real law_series(const LawString& string, Real lambda, Real displacement, Real stiffness) {
  return bisect(displacement, [&](Real delta) {
    return law_force(string, lambda, delta) - stiffness * (displacement - delta);
  });
}

Real law_deflection(const LawString& string, Real lambda, Real force, Real longest) {
  return bisect(longest, [&](Real delta) { return law_force(string, lambda, delta) - force; });
}

VertexSpring vertex_spring(const LawString& string, Real lambda, Real vertex, Real kt) {
  const Real compliance = std::max(Real{0}, 1 / string.contact_stiffness - 1 / kt);
  if (!(compliance > 0)) {
    return {law_force(string, lambda, vertex), law_energy(string, lambda, vertex)};
  }
  const Real delta = law_series(string, lambda, vertex, 1 / compliance);
  const Real force = (vertex - delta) / compliance;
  return {force, law_energy(string, lambda, delta) + compliance * force * force / 2};
}

SphereRest sphere_rest(const LawString& string, Real lambda, Real vertex, Real reach) {
  const Real run = std::min(lambda, 1 - lambda) * string.length;
  const Real leg = std::hypot(run, vertex);
  const Real height = reach * leg / run;
  const Real beside = height * vertex / leg;
  return {height, 1 - beside / leg};
}

SpherePress press_sphere(const LawString& string, Real lambda, Real displacement, Real reach,
                         Real kt) {
  const auto force = [&](Real vertex) {
    return vertex_spring(string, lambda, vertex, kt).force /
           sphere_rest(string, lambda, vertex, reach).share;
  };
  const Real vertex = bisect(displacement, [&](Real u) {
    const Real lowered = reach - displacement;  // of the hand above the axis at rest
    return force(u) - kt * (sphere_rest(string, lambda, u, reach).height - u - lowered);
  });
  return {vertex, force(vertex)};
}

}  // namespace hapticd::test
