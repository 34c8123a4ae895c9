// The law of a string under a finger (Eq. 10-12) straight from its geometry, in long double, and
// what a sphere makes of it: the truth for strings in the contact problem. Shares no code with
// core/instrument. SI. Not RT.
#pragma once

#include "core/instrument/string_parameters.h"

namespace hapticd::test {

/// What the law needs of a string.
struct LawString {
  long double length;             ///< L, m
  long double tension;            ///< T, N
  long double axial;              ///< E pi R^2, N
  long double contact_stiffness;  ///< kc, N/m
};

[[nodiscard]] LawString law_string(const StringParameters& parameters);

/// F(delta), N.
[[nodiscard]] long double law_force(const LawString& string, long double lambda, long double delta);

/// T ext + E A ext^2 / (2 L), J.
[[nodiscard]] long double law_energy(const LawString& string, long double lambda,
                                     long double delta);

/// Pull of the two halves on the finger along the axis, from A to B, N: their tension times their
/// cosines.
[[nodiscard]] long double law_lateral(const LawString& string, long double lambda,
                                      long double delta);

/// delta with F(delta) = stiffness (displacement - delta), by bisection, m.
[[nodiscard]] long double law_series(const LawString& string, long double lambda,
                                     long double displacement, long double stiffness);

/// delta with F(delta) = force, by bisection up to `longest`, m.
[[nodiscard]] long double law_deflection(const LawString& string, long double lambda,
                                         long double force, long double longest);

/// The string as a tool coupled with kt meets it at its vertex: in series with what kt is stiffer
/// than kc.
struct VertexSpring {
  long double force;   ///< N
  long double energy;  ///< J
};

[[nodiscard]] VertexSpring vertex_spring(const LawString& string, long double lambda,
                                         long double vertex, long double kt);

/// How a sphere rests on a string that runs straight from its ends to a vertex under the sphere's
/// centre: on the steeper of the two legs, beside the vertex.
struct SphereRest {
  long double height;  ///< of the centre above the vertex, m
  long double share;   ///< what the string yields there, m per m of its vertex
};

/// `reach`: distance from the sphere's centre to the axis it touches, m.
[[nodiscard]] SphereRest sphere_rest(const LawString& string, long double lambda,
                                     long double vertex, long double reach);

/// What a sphere finds that is pressed into a string.
struct SpherePress {
  long double vertex;  ///< deflection of the string's vertex, m
  long double force;   ///< on the sphere, N
};

/// A sphere right above the string at lambda, whose centre the hand has pressed `displacement`
/// below where it first touches.
[[nodiscard]] SpherePress press_sphere(const LawString& string, long double lambda,
                                       long double displacement, long double reach, long double kt);

}  // namespace hapticd::test
