// What makes a string: geometry, tension, material, tuning, damping. Checked once when a scene is
// built or a live parameter changes; the tick reads the constants derived from it. SI, frame W.
// Source of the mechanics: the paper's Eq. 10-13; N. H. Fletcher and T. D. Rossing, "The Physics of
// Musical Instruments", 2nd ed., chapter 2. RT: plain data; a check takes 20 ns, the constants 5
// ns.
#pragma once

#include <cstdint>
#include <optional>

#include "core/instrument/parameter_range.h"
#include "core/math/realtime.h"
#include "core/math/vector.h"

namespace hapticd {

/// What a contact does to a string.
enum class StringContact : std::uint8_t {
  kStraight,  ///< the string stays straight in the contact problem; only its force is a string's
  kYielding,  ///< the string yields: two unknowns of the contact problem while it is touched
};
inline constexpr StringContact kMaxStringContact = StringContact::kYielding;

/// How far up the ladder of models a string may climb; StringLevel on the wire.
enum class StringDetail : std::uint8_t {
  kLine,         ///< a line that never moves and pushes back like a wall
  kStatic,       ///< static deflection under a finger (Eq. 10-13)
  kFundamental,  ///< and the fundamental after a release (Eq. 9)
  kModes,        ///< and further modes
};

/// What decides the pitch when the tension changes; Tuning on the wire.
enum class StringTuning : std::uint8_t {
  kFrequency,  ///< the frequency where it is given, and the density follows
  kTension,    ///< the density where it is given, and the pitch follows
};

/// An axial stiffness that is not given, N: 0 is one of a string that stretches freely.
inline constexpr double kNoAxialStiffness = -1.0;

/// One string as a scene describes it. Field names and ranges are those of scene.proto.
struct StringParameters {
  Array3 p_WA{};                   ///< end A, m, |component| <= 1e7
  Array3 p_WB{};                   ///< end B, m; A == B is a sphere
  double radius = 0.34e-3;         ///< R, m, [0, 1]
  double tension = 30.0;           ///< T, N, [0, 1e6]; 0 is slack and gives no tone
  double youngs_modulus = 1.9e11;  ///< E, Pa, [0, 1e13]; without effect beside axial_stiffness
  /// E A, N, [0, 1e12]: of a wound string that of its core. kNoAxialStiffness: E pi R^2.
  double axial_stiffness = kNoAxialStiffness;
  /// kg/m, (0, 100]; 0: not given. Beside a frequency it is only checked, unless `tuning` says that
  /// it decides.
  double linear_density = 0.0;
  /// Tuning: frequency of the fundamental, Hz, (0, 2e4]; 0: not given, then from linear_density;
  /// neither: the string never sounds.
  double frequency = 0.0;
  StringTuning tuning = StringTuning::kFrequency;
  double decay = 0.5;  ///< T_d of the free amplitude, s, (0, 1000]
  /// b, 1/s, [0, 1e3]: mode n decays by exp(-(1 / decay + n^2 b) t).
  double loss_n2 = 0.002;
  double touch_decay = 0.03;  ///< T_d while a finger touches the ringing string, s, (0, 1000]
  StringContact model = StringContact::kYielding;
  double k_s = 1.0;  ///< haptic displacement per metre of deflection, (0, 1e6]; kStraight only
  /// kc, N/m, [1e-3, 1e9]: in series with the string, which bounds it at the ends. Above the kt of
  /// the tool it has no effect.
  double contact_stiffness = 1000.0;
  double inharmonicity = 0.0;         ///< B, [0, 0.1]: f_n = n f_1 sqrt((1 + B n^2) / (1 + B))
  double friction_coefficient = 0.0;  ///< mu, [0, 10]
  StringDetail max_level = StringDetail::kModes;
};

/// Strings shorter than this count as A == B, m. Normal value 1e-9; far smaller would let
/// E A / length leave the range of a double.
inline constexpr double kMinString = 1e-9;

/// Highest fundamental, Hz.
inline constexpr double kMaxFrequency = 2e4;

/// The first fault of `parameters`, none when all is well. Non-finite numbers are out of range. A
/// linear density alone, which then is the tuning, must give a fundamental in the range of
/// frequency_hz.
[[nodiscard]] HD_REALTIME std::optional<ParameterFault> check_string(
    const StringParameters& parameters) noexcept;

/// Not refused, but doubtful: a density and a tuning that disagree by more than 20 % in density.
/// Precondition: check_string found nothing.
[[nodiscard]] HD_REALTIME std::optional<ParameterFault> doubt_string(
    const StringParameters& parameters) noexcept;

/// What the tick reads of a string. Nothing in it is ever NaN or infinite.
struct StringConstants {
  double length = 0.0;           ///< L = |AB|, m; 0 where it is below kMinString
  double tension = 0.0;          ///< T, N
  double axial_stiffness = 0.0;  ///< E A as given, or E pi R^2, N
  /// f_1, Hz; 0: the string never sounds (no tuning, slack, A == B, or a mass no double holds).
  double frequency = 0.0;
  double modal_mass = 0.0;   ///< mu L / 2 with mu = T / (2 L f_1)^2, kg; 0 where f_1 is
  double decay = 0.0;        ///< s
  double loss_n2 = 0.0;      ///< 1/s
  double touch_decay = 0.0;  ///< s
  double k_s = 1.0;
  double contact_stiffness = 0.0;  ///< kc, N/m
  double inharmonicity = 0.0;
  double friction_coefficient = 0.0;
  StringContact model = StringContact::kStraight;
  StringDetail max_level = StringDetail::kLine;
  bool shared = false;  ///< it is the part of a string that another tool holds, too
};

/// E A of a string, N: as given, or E pi R^2.
[[nodiscard]] HD_REALTIME double axial_stiffness_of(const StringParameters& parameters) noexcept;

/// Whether the linear density decides the pitch, which then follows the tension; else the frequency
/// does, if there is one.
[[nodiscard]] HD_REALTIME bool density_decides(const StringParameters& parameters) noexcept;

/// Linear density with which a string of `length` (m, > 0) under `tension` (N) sounds at
/// `frequency` (Hz, > 0), kg/m: T / (2 L f_1)^2.
[[nodiscard]] HD_REALTIME double tuned_density(double length, double tension,
                                               double frequency) noexcept;

/// Constants of checked parameters. A == B is a sphere, which cannot yield: its contact becomes
/// kStraight, its detail kLine.
[[nodiscard]] HD_REALTIME StringConstants
derive_string(const StringParameters& parameters) noexcept;

/// k_s from the device: k0 of a string of `length` (m, > 0) at `lambda` in (0, 1) under
/// `reference_tension` (N, > 0) over the device's largest stiffness (N/m, > 0). To be frozen at
/// load: were it recomputed when T, E or R change, they could not be felt.
[[nodiscard]] HD_REALTIME double k_s_from_device(double length, double reference_tension,
                                                 double lambda, double device_stiffness) noexcept;

}  // namespace hapticd
